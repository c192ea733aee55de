"""The second formulation, for soft links: frames that follow the elastic links, exact however far they turn.

A chain of carriers, one an element.  A carrier starts at the section where the element before it ends and is
turned so that its x axis goes to the element's end, whatever the element's own bending.  With o, R of the
section before (for a link's first element turned by the joint) and an element's unknowns

    u                          its stretch
    b = (tau/2, b_y, b_z)      rotation vector from the section at its start to the carrier
    c = (tau/2, c_y, c_z)      rotation vector from the carrier to the section at its end

    carrier   o, R B                               B = exp([b]x), C = exp([c]x)
    field     o + R B (x + N(x) d)                 rows d: (0, -b) at the start, (u e_x, c) at the end
    section   o + R B (L + u) e_x,  R B C

so that N is the field of beam.py, small about the chord, half of the twist each way, and rotations from
element to element are finite and exact.  Nothing depends on what is before but through the frames: stiffness
is block-diagonal in the elements, and mass is eliminated from the tip to the base with one matrix over a
section's acceleration (solve/co_moving_*.py).  q is the motor's angle.  Bodies at a link's end
ride on its last section.

The chord, and not the section at the start, carries an element because nodes then stay where they are when
sections swing faster than a step resolves: b and the rotation before it swing against each other.

The error is that of the field inside one element, of the order of its squared rotation about the chord: more
elements remove it.

A row of the nodal arrays holds (u, b_z, b_y, tau, c_y, c_z) of the element that ends there, in the plane
(u, b, c).  Each function picks the plane or
space when it is compiled.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from . import elastic_motion, plane, space


@kernel
def place(chain, work, x):
    """Carriers and nodal displacements at the unknowns x."""
    place_as(chain.dofs, chain, work, x)


@kernel
def place_as(dofs, chain, work, x):
    """place, the number of dofs an argument."""
    if len(dofs) == 3:
        plane.place(chain, work, x)
    else:
        space.place(chain, work, x)


@kernel
def accelerate(chain, work, v, a):
    """Motion of carriers and sections at rates v and accelerations a of the unknowns."""
    accelerate_as(chain.dofs, chain, work, v, a)


@kernel
def accelerate_as(dofs, chain, work, v, a):
    """accelerate, the number of dofs an argument."""
    if len(dofs) == 3:
        plane.accelerate(chain, work, v, a)
    else:
        space.accelerate(chain, work, v, a)


@kernel
def gather(chain, work, out):
    """Add inertia, elastic and damping forces to those of the unknowns."""
    gather_as(chain.dofs, chain, work, out)


@kernel
def gather_as(dofs, chain, work, out):
    """gather, the number of dofs an argument."""
    if len(dofs) == 3:
        plane.gather(chain, work, out)
    else:
        space.gather(chain, work, out)


@kernel
def gather_wrenches(chain, work, out):
    """Add the wrenches on the sections alone, without the links' own forces, to those of the unknowns."""
    gather_wrenches_as(chain.dofs, chain, work, out)


@kernel
def gather_wrenches_as(dofs, chain, work, out):
    """gather_wrenches, the number of dofs an argument."""
    if len(dofs) == 3:
        plane.gather_wrenches(chain, work, out)
    else:
        space.gather_wrenches(chain, work, out)


@kernel
def stiffness_times(chain, work, y, scale, out):
    """scale * K y into out (n,), at the placed configuration."""
    stiffness_times_as(chain.dofs, chain, work, y, scale, out)


@kernel
def stiffness_times_as(dofs, chain, work, y, scale, out):
    """stiffness_times, the number of dofs an argument."""
    if len(dofs) == 3:
        plane.stiffness_times(chain, work, y, scale, out)
    else:
        space.stiffness_times(chain, work, y, scale, out)


@kernel
def momenta(chain, work, y, out):
    """Add M y to out (n,), for Rayleigh's alpha."""
    elastic_motion.momenta(chain.dofs, chain, work, y, out)
