"""Recorded runs, driven again through the simulator."""
