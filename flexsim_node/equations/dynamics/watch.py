"""The validity watch of every step: how far a motion is from where its equations cease to hold.

A step's end is held against the scene's limits.  Beyond `stop` the step is not accepted: the run ends with
the reason and the last good state.  Beyond `warn` it is remembered.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import BENDING, COUNT, DISPLACEMENT, FIRST, OMEGA
from ..co_moving import loads

# rows of Chain.limit and columns of Workspace.validity
ELASTIC_ROTATION, SPIN_RATIO, CORRECTION = range(3)


@kernel
def valid(chain, work):
    """Whether the motion that the last residual saw is within the limits.

    The largest values go into work.validity, the links where they were beside them.
    """
    within = below(chain, work, CORRECTION, work.correction[0], -1)
    return links_within(chain.co_moving, chain, work) and within


@kernel
def links_within(co, chain, work):
    """valid for the links, whichever the formulation; the other one is not even compiled."""
    if len(co) > 0:
        return co_moving_within(chain, work)
    else:
        return erls_within(chain, work)


@kernel
def co_moving_within(chain, work):
    """valid for links with co-moving frames: rotations count from an element's chord, others are exact."""
    joint, within = chain.joint, True
    for n in range(chain.link.shape[0]):
        turn, spin = loads.measure(chain, work, n)
        within = below(chain, work, ELASTIC_ROTATION, turn, n) and within
        if joint[n, BENDING] > 0.0:
            within = below(chain, work, SPIN_RATIO, spin / joint[n, BENDING], n) and within
    return within


@kernel
def erls_within(chain, work):
    """valid for links of the ERLS."""
    link, joint, d = chain.link, chain.joint, work.node[DISPLACEMENT]
    planar = len(chain.dofs) == 3
    within = True
    for n in range(link.shape[0]):
        first, count = link[n, FIRST], link[n, COUNT]
        turn = 0.0
        for i in range(first, first + count + 1):
            turn = max(turn, abs(d[i, 2])) if planar else max(turn, abs(d[i, 3]), abs(d[i, 4]), abs(d[i, 5]))
        within = below(chain, work, ELASTIC_ROTATION, turn, n) and within
        if joint[n, BENDING] > 0.0:
            f = work.frame[n]
            # about the beam's own axis it does not bend
            spin = f[OMEGA + 2] if planar else (f[OMEGA + 1] ** 2 + f[OMEGA + 2] ** 2) ** 0.5
            within = below(chain, work, SPIN_RATIO, abs(spin) / joint[n, BENDING], n) and within
    return within


@kernel
def below(chain, work, row, value, n):
    """Keep the largest value of a row and its link; tells whether it is below the limit."""
    if value > work.validity[0, row]:
        work.validity[0, row], work.validity[1, row] = value, n
    return value <= chain.limit[row, 1]
