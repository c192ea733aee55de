"""Thermo-elastic deformation of the leaf: solid bricks, and a layered shell."""
