"""The fit of a door to a test, under the name that users import."""

from .analysis.fit import fit, foresee_fit

__all__ = ["fit", "foresee_fit"]
