"""What kernels may do with their arithmetic."""

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""All but pretend that nothing is infinite or not a number."""
