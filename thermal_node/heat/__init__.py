"""Kernels of heat conduction: flows, enthalpy, implicit stages and their linear systems."""
