"""What accuracy costs in time: a reference, a grid of points, a frontier, a choice."""
