"""Nodal dofs of a link after its start: unknowns of their own, or dependent on others.

A dof is dependent where it is zeroed or where its effect is off: then it is a combination of the dofs of its
node and of the node before.
"""

from __future__ import annotations

from .kernel import kernel


@kernel
def own_nodes(chain, first, count, y, rows):
    """Fill the nodal rows of a link after its start from the unknowns y and the dependencies."""
    index, dependency = chain.unknown, chain.dependency
    b = len(chain.dofs)
    for i in range(first + 1, first + count + 1):
        dependent = False
        for k in range(b):
            n = index[i, k]
            if n >= 0:
                rows[i, k] = y[n]
            else:
                dependent = True
                rows[i, k] = 0.0
        if dependent:
            for k in range(b):
                if index[i, k] < 0:
                    total = 0.0
                    for m in range(b):
                        total += dependency[i, k, m] * rows[i, m]
                        total += dependency[i, k, b + m] * rows[i - 1, m]
                    rows[i, k] = total


@kernel
def fold_forces(chain, first, count, force, out):
    """Add forces on a link's nodes after its start to those of their unknowns, or of what they depend on."""
    index, dependency = chain.unknown, chain.dependency
    b = len(chain.dofs)
    for i in range(first + count, first, -1):
        for k in range(b):
            if index[i, k] < 0:
                for m in range(b):
                    force[i, m] += dependency[i, k, m] * force[i, k]
                    force[i - 1, m] += dependency[i, k, b + m] * force[i, k]
        for k in range(b):
            if index[i, k] >= 0:
                out[index[i, k]] += force[i, k]
