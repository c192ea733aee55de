"""Time integration, one method a file, each with the same `step`."""

from . import generalized_alpha, rosenbrock_w, runge_kutta_4

METHODS = {
    "rosenbrock_w": rosenbrock_w,
    "generalized_alpha": generalized_alpha,
    "runge_kutta_4": runge_kutta_4,
}
