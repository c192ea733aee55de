"""What does not change while a door burns: materials, arrays of the mesh, probes."""
