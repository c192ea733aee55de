"""Where the links are and how they move: rigid frames of the ERLS and the nodal motion over them.

The nodal rows d of a link, in its body frame, are linear in the unknowns u (nodal displacements of the
parent's end, turned by the joint; the link's own), d = T(q) u.  `place` writes d and the rotations,
`nodal_rates` applies the linear map (T, dT/dq u) to any vector of rates, `gather` its transpose,
`accelerate` adds what is quadratic in the rates.  Each is that of the plane or of space: `len(dofs)` of an
argument is a constant to the compiler, which then leaves the other out.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import DISPLACEMENT, FIRST, FIRST_ELEMENT
from ...model.reduced.layout import MODES
from .. import co_moving
from ..reduced import plane as planar_reduced_beam
from ..reduced import space as spatial_reduced_beam
from . import planar_kinematics, spatial_kinematics


@kernel
def spatial_row(row, planar, r):
    """Copy a nodal row into r (6,)."""
    if planar:
        r[0], r[1], r[2], r[3], r[4], r[5] = row[0], row[1], 0.0, 0.0, 0.0, row[2]
    else:
        for k in range(6):
            r[k] = row[k]


@kernel
def place(chain, work, x):
    """Frames and nodal displacements at the unknowns x."""
    place_in(chain.co_moving, chain.dofs, chain, work, x)
    shape(chain.reduction, chain.dofs, chain, work)


@kernel
def place_in(co, dofs, chain, work, x):
    """`place`, with frames that follow the elements, or of the ERLS, in the plane or in space."""
    if len(co) > 0:
        co_moving.place(chain, work, x)
    elif len(dofs) == 3:
        planar_kinematics.place(chain, work, x)
    else:
        spatial_kinematics.place(chain, work, x)


@kernel
def shape(reduction, dofs, chain, work):
    """Find of reduced links at their nodal displacements what forces and matrix have in common."""
    if len(reduction) == 0:
        return
    d, data, own = work.node[DISPLACEMENT], chain.modal, work.modal
    for n in range(chain.link.shape[0]):
        size, e, first = chain.reduced[n], chain.element[chain.link[n, FIRST_ELEMENT]], chain.link[n, FIRST]
        if size[MODES] < 0:
            continue
        if len(dofs) == 3:
            planar_reduced_beam.shape(size, data, own, e, d, first)
        else:
            spatial_reduced_beam.shape(size, data, own, e, d, first)


@kernel
def nodal_rates(chain, work, y, rows):
    """Nodal rows of the unknowns' rates y, at the placed configuration."""
    nodal_rates_in(chain.dofs, chain, work, y, rows)


@kernel
def nodal_rates_in(dofs, chain, work, y, rows):
    """`nodal_rates`, in the plane or in space."""
    if len(dofs) == 3:
        planar_kinematics.nodal_rates(chain, work, y, rows, False, y)
    else:
        spatial_kinematics.nodal_rates(chain, work, y, rows, False, y)


@kernel
def accelerate(chain, work, v, a):
    """Motion of frames and nodes at rates v and accelerations a of the unknowns."""
    accelerate_in(chain.co_moving, chain.dofs, chain, work, v, a)


@kernel
def accelerate_in(co, dofs, chain, work, v, a):
    """`accelerate`, with frames that follow the elements, or of the ERLS, in the plane or in space."""
    if len(co) > 0:
        co_moving.accelerate(chain, work, v, a)
    elif len(dofs) == 3:
        planar_kinematics.accelerate(chain, work, v, a)
    else:
        spatial_kinematics.accelerate(chain, work, v, a)


@kernel
def gather(chain, work, out):
    """Add nodal forces and links' wrenches, through the transposed map, to the unknowns' forces."""
    gather_in(chain.dofs, chain, work, out)


@kernel
def gather_in(dofs, chain, work, out):
    """`gather`, in the plane or in space."""
    if len(dofs) == 3:
        planar_kinematics.gather(chain, work, out)
    else:
        spatial_kinematics.gather(chain, work, out)
