"""The equations of motion as kernels, from nodal motion to accelerations."""
