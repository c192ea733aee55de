"""How kernels are compiled and kept; the only room that knows numba's inside."""
