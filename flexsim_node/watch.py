"""The validity watch: how far a motion is from where its equations cease to hold.

Every step's end is held against the scene's limits.  Beyond `stop` the step is not accepted: the run ends
with the reason and the last good state.  Beyond `warn` it is remembered.
"""

from __future__ import annotations

from .chain import BENDING, BUCKLING, COUNT, DISPLACEMENT, FIRST, FIRST_ELEMENT, OMEGA
from .kernel import kernel
from .planar_beam import axial_force as planar_axial_force
from .spatial_beam import axial_force as spatial_axial_force

# rows of Chain.limit and columns of Workspace.validity
ELASTIC_ROTATION, SPIN_RATIO, AXIAL_LOAD, CORRECTION = range(4)


@kernel
def watch(chain, work):
    """Hold the motion that the workspace shows against the limits; tells whether it passes one.

    The largest values go into work.validity, the links where they were beside them.
    """
    link, joint, d = chain.link, chain.joint, work.node[DISPLACEMENT]
    planar = len(chain.dofs) == 3
    passed = reached(chain, work, CORRECTION, work.correction[0], -1)
    for n in range(link.shape[0]):
        first, count = link[n, FIRST], link[n, COUNT]
        turn = 0.0
        for i in range(first, first + count + 1):
            turn = max(turn, abs(d[i, 2])) if planar else max(turn, abs(d[i, 3]), abs(d[i, 4]), abs(d[i, 5]))
        passed = reached(chain, work, ELASTIC_ROTATION, turn, n) or passed
        if joint[n, BENDING] > 0.0:
            f = work.frame[n]
            # about the beam's own axis it does not bend
            spin = f[OMEGA + 2] if planar else (f[OMEGA + 1] ** 2 + f[OMEGA + 2] ** 2) ** 0.5
            passed = reached(chain, work, SPIN_RATIO, abs(spin) / joint[n, BENDING], n) or passed
        if joint[n, BUCKLING] > 0.0:
            push = 0.0
            for k in range(count):
                e, i = chain.element[link[n, FIRST_ELEMENT] + k], first + k + 1
                pull = planar_axial_force(e, d, i) if planar else spatial_axial_force(e, d, i)
                push = max(push, -pull)
            passed = reached(chain, work, AXIAL_LOAD, push / joint[n, BUCKLING], n) or passed
    return passed


@kernel
def reached(chain, work, row, value, n):
    """Keep the largest value of a row and its link; tells whether it passes the limit."""
    if value > work.validity[0, row]:
        work.validity[0, row], work.validity[1, row] = value, n
    return value > chain.limit[row, 1]
