"""Nodal motion over the rigid links' frames: poses, rates, accelerations, and back."""
