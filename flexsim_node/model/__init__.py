"""The immutable arrays of a scene: numbering, constants, zeroed dofs, closing equations."""
