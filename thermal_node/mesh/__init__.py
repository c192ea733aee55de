"""Meshes of the door leaf."""
