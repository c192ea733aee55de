"""One beam element and one rigid body: section, field, mass, stiffness, in the plane and in space."""
