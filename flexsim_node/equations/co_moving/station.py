"""Stations on co-moving frames, for sensing.py: an element's nodal rows, and what all beyond it needs."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...elements import spatial_beam
from ...model.chain import REACH
from . import plane, space


@kernel
def element_rows(dofs, work, i, kind, out):
    """Write the rows of start and end of the element that ends at node i into out (2, 6)."""
    if len(dofs) == 3:
        pair = work.pair[0]
        plane.element_rows(work.node[kind, i], pair)
        out[:] = 0.0
        for k in range(2):
            out[k, 0], out[k, 1], out[k, 5] = pair[k, 0], pair[k, 1], pair[k, 2]
    else:
        space.element_rows(work.node[kind, i], out)


@kernel
def wrench_beyond(chain, work, i, m, e, frame, rows, rates, accelerations, t, scratch, out):
    """Write the wrench (6,) about its carrier that element m, e (14,), and all beyond its end, node i, need.

    The last gather has left what is beyond in work.section_wrench.  m is -1 where a link has no element.
    """
    w = work.section_wrench[i]
    if len(chain.dofs) == 3:
        out[0], out[1], out[2], out[3], out[4], out[5] = w[0], w[1], 0.0, 0.0, 0.0, w[2]
    else:
        for k in range(6):
            out[k] = w[k]
    if m < 0:
        return
    reach = work.moving[i, REACH]
    out[4] -= reach * out[2]
    out[5] += reach * out[1]
    nodes = t[7:9]
    nodes[:] = 0.0
    # Rayleigh's alpha is in the accelerations
    spatial_beam.inertia_force(e, frame, rows, rates, accelerations, 1, 0.0, True, True, nodes, out, scratch)
