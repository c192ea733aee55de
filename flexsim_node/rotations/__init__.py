"""Finite rotations: rotation vectors, sections turned to second order."""
