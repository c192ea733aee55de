"""Residual, accelerations and energy of the whole chain, and their tangents."""
