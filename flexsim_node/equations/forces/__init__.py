"""Forces from outside, and of damping."""
