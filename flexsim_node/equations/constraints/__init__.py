"""Forces that keep loops closed and joints at rest: closing joints, Coulomb friction."""
