"""The arrays that the compiled kernels work on: `Chain` never changes, `Workspace` is allocated once.

Each link has a body frame: origin at the start of its beam, axes along the beam axes.  A link's own
nodes are numbered from its start (a copy of the end node of its parent, turned by the joint) to its end.
A nodal row is (ux, uy, uz, rx, ry, rz), in a planar chain (ux, uy, rz).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compiled.aligned import zeros
from ..compiled.by_reference import by_reference
from .reduced.layout import buffer_length

# columns of Chain.link
KIND, Q, PHI, FIRST, COUNT, FIRST_ELEMENT, PARENT, FIRST_BODY, BODIES, MOTOR = range(10)
FIXED, REVOLUTE, PRISMATIC = range(3)
# columns of Chain.joint: link length, joint axis in the link's and the parent's body frame, losses, spring
# and damper between motor and link, the link's first bending frequency (rad/s), buckling load (N), or zero;
# the length of a rigid link whose end moves to second order as its start turns, or zero
TIP, AXIS, PARENT_AXIS, ANGLE = 0, 1, 4, 7
VISCOUS, COULOMB, COULOMB_SPEED, ROTOR, SPRING, DAMPER = 8, 9, 10, 11, 12, 13
BENDING, BUCKLING, BOWED = 14, 15, 16
# columns of Chain.closing, an equation each: what it equates, the links on whose ends its points or
# directions a, b and its direction d ride (-1: the base), the loop it belongs to
EQUATION, LINK_A, LINK_B, LINK_D, CLOSING_LOOP = range(5)
POINT, DIRECTION = range(2)
# columns of Workspace.frame: angular velocity, acceleration of the origin, angular acceleration, rotation
# to the parent (row-wise), the start's row without the joint's own rotation, its derivative by q, lever; the
# rotational entries of the start's row by those of the parent's end (3, 3) and by the joint's own rotation
# (3,) (joint_turn.py), the derivatives of a bowed link's length by them (2,), the start's displacement by
# those of the parent's end where the link slides (3, 3), the joint's own rotation.  The (3, 3) are
# transposed, as ROTATION stands to E^T.
OMEGA, LINEAR, ANGULAR, ROTATION, START, BY_Q, LEVER = 0, 3, 6, 9, 18, 24, 30
TURN_OVER, TURN_AXIS, BOW, SLIDE_OVER, PSI, FRAME_COLUMNS = 33, 42, 45, 47, 56, 64
# columns of Workspace.moving, a row for each node's carrier: motion and ROTATION (to the carrier before) as
# above, then the section's rotation and place from the carrier, the vectors b, c and the coefficients of
# their tangents; of a link's start instead of these two the joint's axis and lever where it slides
HALF, REACH, TURN, SERIES = 18, 27, 30, 36
SLIDE, LEAD = 30, 33
# columns of Workspace.kept_moving after ROTATION (at 0) and REACH (at 9): how unknowns move a section
KEPT_TURN, KEPT_MOMENT = 12, 27
# rows of Workspace.node
DISPLACEMENT, RATE, ACCELERATION, TRIAL = range(4)
# entries of Chain.setting: gravity (3), Rayleigh's coefficients, whether a factorisation may serve the next
# step's first stage too (where q follows the links' chords; at their roots it swings with the elastic modes),
# whether the elastic displacement meets Coriolis' acceleration, and centrifugal softening,
# how many of the unknowns are joint coordinates and motors' angles, Rayleigh's alpha on the elastic velocity
# alone (ALPHA is the thesis' form)
GRAVITY, ALPHA, BETA, KEEP, CORIOLIS, SPIN, COORDINATES, RELATIVE = 0, 3, 4, 5, 6, 7, 8, 9


class Chain(NamedTuple):
    """A robot as the kernels see it: L links, E elements, N nodes, n unknowns, B dofs a node (3 or 6)."""

    # lengths of tuples are known when a kernel is compiled: what another robot needs is left out
    dofs: tuple[int, ...]  # of a node in space, B of them
    loops: tuple[int, ...]  # (their number,), or () where there are none
    co_moving: tuple[int, ...]  # (1,) where frames follow the elements, else ()
    reduction: tuple[int, ...]  # (1,) where links are reduced to modes, else ()
    link: np.ndarray  # (L, 10) int64
    joint: np.ndarray  # (L, 17)
    rotation: np.ndarray  # (L, 3, 3, 3): constant, cosine and sine part of the joint's rotation
    element: np.ndarray  # (E, 15), columns of beam.py
    mass: np.ndarray  # (E, 2B, 2B), nodes ordered (end, start); co-moving (E, B, B) over an element's own
    stiffness: np.ndarray  # likewise
    unknown: np.ndarray  # (N, B) int64: the unknown of a nodal dof, or -1 where it depends on others
    dependency: np.ndarray  # (N, B, 2B): on the dofs of this node and of the one before
    body: np.ndarray  # (bodies, 4, 4), see rigid_body.py
    body_mass: np.ndarray  # (bodies, B, B)
    body_place: np.ndarray  # (bodies,) int64: node
    place: np.ndarray  # (N,) distance of a node from the link's start, m
    setting: np.ndarray  # (10,)
    limit: np.ndarray  # (3, 2): warn and stop, rows of watch.py
    closing: np.ndarray  # (R, 5) int64: the equations of the closing joints, see closure.py
    anchor: np.ndarray  # (R, 9): a, b, d in body axes, points from the links' ends
    reduced: np.ndarray  # (L, 47 + 2P) int64: links that are one element with modes, see reduced/layout.py
    modal: np.ndarray  # their constants
    rubbing: np.ndarray  # (k,) int64: links at whose joints there is Coulomb friction


class Workspace(NamedTuple):
    """Every buffer of a step, sized for one chain."""

    frame: np.ndarray  # (L, 64)
    kept: np.ndarray  # (L, 64): the frames at the last factorisation
    node: np.ndarray  # (4, N, B)
    force: np.ndarray  # (N, B)
    wrench: np.ndarray  # (L, B)
    attitude: np.ndarray  # (L, 9): rotation of the body frames to the base, where a load asks for it
    external: np.ndarray  # (2, L, 6): force and moment on the links' ends, in beam axes and in base axes
    course: np.ndarray  # (3, 2, L, 6): those at start, middle and end of the step
    loaded: np.ndarray  # (2,) bool: whether there are any
    validity: np.ndarray  # (2, 3): largest values that the watch saw, and the links where
    correction: np.ndarray  # (1,): of the last Newton step, m or rad
    held: np.ndarray  # (L,) bool: joints whose motion is prescribed
    iteration: np.ndarray  # (E, 2B, 2B): mass + scale * stiffness, of reduced links without their modes
    # (4,): of the stiffness, of the joints' damping and of their springs, -1 before any; of the elastic
    # motion's mass, with Rayleigh's alpha (damping.py)
    scale: np.ndarray
    # (N * B + 1, 3B + 1): rows of the factorisation, and one that a vector reads into
    pivot: np.ndarray
    joint_pivot: np.ndarray  # (L, 2, 2B + 2)
    spring: np.ndarray  # (L, 2): joint spring in the matrix, 1 / pivot of its motor
    interface: np.ndarray  # (L, 2B, 2B)
    load: np.ndarray  # (L, 2B)
    answer: np.ndarray  # (L, 2B)
    front: np.ndarray  # (3B, 3B)
    vector: np.ndarray  # (11, n): of the methods 0 to 7, of friction 8, of Rayleigh's alpha 9 and 10
    drive: np.ndarray  # (4, m): torque and prescribed motion between the ends of a step
    memory: np.ndarray  # (n,): what a method keeps from step to step
    arrival: np.ndarray  # (n,): the accelerations that a method has at the step's end
    square: np.ndarray  # (2B, 2B)
    gradient: np.ndarray  # (12, 12): of an element's strains, and times their stiffnesses
    coupling: np.ndarray  # (2B + 1, B)
    inertia: np.ndarray  # (B, B)
    scratch: np.ndarray  # (30, 3)
    row: np.ndarray  # (6, 36)
    closure: np.ndarray  # (R, 2n + R + 4): G, M^-1 G^T, S = G M^-1 G^T, columns of closure.py
    pose: np.ndarray  # (L, 15): origin, rotation and the origin's velocity in the base frame; of loops only
    # of co-moving frames, else empty
    moving: np.ndarray  # (N, 44)
    kept_moving: np.ndarray  # (N, 36): what the last factorisation keeps of them
    section: np.ndarray  # (N, 9): motion of the section at a node, in its carrier's axes
    section_wrench: np.ndarray  # (N, B)
    section_matrix: np.ndarray  # (N, B, B)
    section_load: np.ndarray  # (N, B)
    section_answer: np.ndarray  # (N, B)
    pair: np.ndarray  # (4, 2, B): rows of one element's two nodes
    carrier: np.ndarray  # (2, B, B)
    modal: np.ndarray  # buffers of the reduced links, see reduced/layout.py
    rubbing: np.ndarray  # (k, n + 2k + 7): Coulomb friction, columns of friction.py


class Robot(NamedTuple):
    """Everything that a step works on."""

    chain: Chain
    work: Workspace
    x: np.ndarray  # (n,) unknowns
    v: np.ndarray  # (n,) their rates
    torque: np.ndarray  # (3, m) at start, middle and end of the step
    motion: np.ndarray  # (3, 3, m) prescribed position, velocity, acceleration at the same times


def workspace(chain: Chain, **shared: np.ndarray) -> Workspace:
    """Allocate the buffers for a chain, but for those that it shares with another."""
    links = len(chain.link)
    nodes, b = len(chain.unknown), len(chain.dofs)
    last = chain.link[:, [Q, PHI, MOTOR]].max(initial=-1)
    unknowns = max(int(chain.unknown.max(initial=-1)), int(last)) + 1
    joints = int(np.sum(chain.link[:, KIND] != FIXED))
    equations, rubs = len(chain.closing), len(chain.rubbing)
    own = nodes if chain.co_moving else 0
    moving = zeros((own, 44))
    moving[:, [HALF, HALF + 4, HALF + 8]] = 1.0
    buffers = Workspace(
        frame=zeros((links, FRAME_COLUMNS)),
        kept=zeros((links, FRAME_COLUMNS)),
        node=zeros((4, nodes, b)),
        force=zeros((nodes, b)),
        wrench=zeros((links, b)),
        attitude=zeros((links, 9)),
        external=zeros((2, links, 6)),
        course=zeros((3, 2, links, 6)),
        loaded=zeros(2, dtype=np.bool_),
        validity=zeros((2, 3)),
        correction=zeros(1),
        held=zeros(links, dtype=np.bool_),
        iteration=zeros(chain.mass.shape),
        scale=np.full(4, -1.0),
        pivot=zeros((nodes * b + 1, 3 * b + 1)),
        joint_pivot=zeros((links, 2, 2 * b + 2)),
        spring=zeros((links, 2)),
        interface=zeros((links, 2 * b, 2 * b)),
        load=zeros((links, 2 * b)),
        answer=zeros((links, 2 * b)),
        front=zeros((3 * b, 3 * b)),
        vector=zeros((16, unknowns)),
        drive=zeros((4, joints)),
        memory=zeros(unknowns),
        arrival=zeros(unknowns),
        square=zeros((2 * b, 2 * b)),
        gradient=zeros((12, 12)),
        coupling=zeros((2 * b + 1, b)),
        inertia=zeros((b, b)),
        scratch=zeros((30, 3)),
        row=zeros((6, 36)),
        closure=zeros((equations, 2 * unknowns + equations + 4)),
        pose=zeros((links if equations else 0, 15)),
        moving=moving,
        kept_moving=zeros((own, 36)),
        section=zeros((own, 9)),
        section_wrench=zeros((own, b)),
        section_matrix=zeros((own, b, b)),
        section_load=zeros((own, b)),
        section_answer=zeros((own, b)),
        pair=zeros((4, 2, b)),
        carrier=zeros((2, b, b)),
        modal=zeros(buffer_length(chain.reduced)),
        rubbing=zeros((rubs, unknowns + 2 * rubs + 7 if rubs else 0)),
    )
    return by_reference(buffers._replace(**shared))
