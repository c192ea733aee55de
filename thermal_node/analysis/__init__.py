"""Whole tests offline: a run and its samples, the fit of materials, a report."""
