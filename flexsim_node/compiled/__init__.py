"""How kernels are compiled and kept; the only room that knows numba's inside."""

from . import kept_kernels  # noqa: F401  before any kernel is loaded
