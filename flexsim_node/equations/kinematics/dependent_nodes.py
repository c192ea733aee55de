"""Nodal dofs of a link after its start: unknowns of their own, or dependent on others.

A dof is dependent where it is zeroed or where its effect is off: then it is a combination of the dofs of its
node and of the node before.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...model.chain import COUNT, FIRST
from ...model.reduced.layout import MODES


@kernel
def own_modes(reduction, chain, n, end, y, rows):
    """Copy the modes of a reduced link n, unknowns in a row, behind its end, which is at `end`."""
    if len(reduction) == 0 or chain.reduced[n, MODES] <= 0:
        return
    begin, z = flat(chain.unknown)[end], flat(rows)
    for i in range(chain.reduced[n, MODES]):
        z[end + i] = y[begin + i]


@kernel
def fold_modes(reduction, chain, n, end, force, out):
    """Add the forces on them to those of their unknowns."""
    if len(reduction) == 0 or chain.reduced[n, MODES] <= 0:
        return
    begin, z = flat(chain.unknown)[end], flat(force)
    for i in range(chain.reduced[n, MODES]):
        out[begin + i] += z[end + i]


@kernel
def six_of_its_own(dofs, index, i):
    """Whether the dofs of node i are six unknowns in a row, as most nodes' are."""
    return len(dofs) == 6 and index[i, 0] >= 0 and index[i, 5] == index[i, 0] + 5


@kernel
def own_nodes(chain, n, y, rows):
    """Fill the nodal rows of link n after its start from the unknowns y and the dependencies.

    The modes of a reduced link follow its end, packed into rows of their own.
    """
    first, count = chain.link[n, FIRST], chain.link[n, COUNT]
    index, dependency = chain.unknown, chain.dependency
    b = len(chain.dofs)
    own_modes(chain.reduction, chain, n, b * (first + count + 1), y, rows)
    for i in range(first + 1, first + count + 1):
        if six_of_its_own(chain.dofs, index, i):
            at = index[i, 0]
            for k in range(6):
                rows[i, k] = y[at + k]
            continue
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
def fold_forces(chain, n, force, out):
    """Add forces on link n's nodes after its start to those of their unknowns, or of what they depend on."""
    first, count = chain.link[n, FIRST], chain.link[n, COUNT]
    index, dependency = chain.unknown, chain.dependency
    b = len(chain.dofs)
    fold_modes(chain.reduction, chain, n, b * (first + count + 1), force, out)
    for i in range(first + count, first, -1):
        if six_of_its_own(chain.dofs, index, i):
            at = index[i, 0]
            for k in range(6):
                out[at + k] += force[i, k]
            continue
        for k in range(b):
            if index[i, k] < 0:
                for m in range(b):
                    force[i, m] += dependency[i, k, m] * force[i, k]
                    force[i - 1, m] += dependency[i, k, b + m] * force[i, k]
        for k in range(b):
            if index[i, k] >= 0:
                out[index[i, k]] += force[i, k]
