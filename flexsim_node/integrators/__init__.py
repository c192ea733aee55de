"""Time integration, one method a file, each with the same `step`.

What a method sets to begin is in its step as well, since each kernel that is called from Python is compiled
with all that it calls.  SMOOTHING: of the accelerations that sensors read, see end_acceleration.py; None
where they are the method's own.
"""

from . import generalized_alpha, rosenbrock_w, runge_kutta_4

METHODS = {
    "rosenbrock_w": rosenbrock_w,
    "generalized_alpha": generalized_alpha,
    "runge_kutta_4": runge_kutta_4,
}
