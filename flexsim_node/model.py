"""From a scene to the immutable arrays of its equations; effects that are off leave no trace here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from . import spatial_beam
from .aligned import aligned
from .beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    COLUMNS,
    HERMITE_MASS,
    INERTIA_Y,
    INERTIA_Z,
    LENGTH,
    MASS,
    POLAR,
    QUADRATIC_MASS,
    SHEAR_Y,
    SHEAR_Z,
    START,
    STIFFENING,
    TORSION,
)
from .by_reference import by_reference
from .chain import FIXED, PRISMATIC, REVOLUTE, Chain
from .effects import Decision, resolve_effects
from .erls import beam_axes, erls_condition, rotation_x, zeroed_directions
from .loops import closing_equations, flat
from .reduced.reduction import ReducedLink, reduce_link, reduced_links
from .rigid_body import body_vectors, pseudo_inertia
from .scene import Scene, SceneError
from .schema import Erls, Link, Payload
from .section import section

PLANAR_DOFS = [0, 1, 5]
CONDITION_LIMIT = 1e8  # of J_0, beyond which the ERLS is not defined by the zeroed dofs


@dataclass(frozen=True)
class Model:
    """A robot ready to be simulated.

    Attributes
    ----------
    chain : the compiled kernels' arrays
    joints : m, number of joint coordinates, the first unknowns
    unknowns : n, joint coordinates and free elastic dofs
    planar : three dofs a node instead of six
    axes : (L, 3, 3), columns are the beam axes in the link's frame
    node_link : (N,) link of every node; node_names : (N,)
    first_node : (L + 1,) where each link's nodes start among these; station : (N,) their distance along it, m
    joint_links : (m,) link at whose start each joint sits
    actuated : (m,) bool, which joints have a motor
    turn : (m,) unknown of the joint's own elastic rotation, or -1 (joint angle = q + that)
    motor : (m,) unknown of the motor's angle where a spring stands between it and the link, or -1
    zeroed : for each link the zeroed dofs, (node, dof) to a direction (6,) in beam axes
    limits : (6, 2) where the validity watch warns and stops
    decision : how the scene's open effects (`auto`) were decided; `scene` is the decided one
    """

    scene: Scene
    chain: Chain
    joints: int
    unknowns: int
    planar: bool
    axes: np.ndarray
    node_link: np.ndarray
    node_names: tuple[str, ...]
    first_node: np.ndarray
    station: np.ndarray
    joint_links: np.ndarray
    turn: np.ndarray
    actuated: np.ndarray
    motor: np.ndarray
    zeroed: list[dict[tuple[int, int], np.ndarray]]
    limits: np.ndarray
    decision: Decision | None = None

    @property
    def swings(self) -> bool:
        """Whether joint coordinates are other than the motors' angles, so that J_0 changes."""
        return any(node > 0 for directions in self.zeroed for node, _ in directions)

    @property
    def turned(self) -> np.ndarray:
        """(m,) unknowns that the motors turn: joint coordinates, or the angles of motors behind springs."""
        return np.where(self.motor >= 0, self.motor, np.arange(self.joints))

    def shown(self, y: np.ndarray) -> np.ndarray:
        """(m,) what the motors' encoders show of the unknowns y (n,), or of their rates.

        That is the motor's own angle where a spring follows, else the joint's, with its elastic rotation.
        """
        own = np.flatnonzero((self.turn >= 0) & (self.motor < 0))
        found = y[self.turned]
        found[own] += y[self.turn[own]]
        return found


def is_planar(scene: Scene) -> bool:
    """Whether nothing in the scene can leave the plane of its joints."""

    def level(body: Payload | None) -> bool:
        if body is None or body.mass == 0.0:
            return True
        i = body.inertia
        return body.center_of_mass[2] == 0.0 and (i is None or (i[0][2] == 0.0 and i[1][2] == 0.0))

    zeroed = scene.erls.zeroed
    return (
        (scene.gravity[2] == 0.0 or not scene.effects.gravity)
        and all(
            abs(link.dh.alpha) < 1e-12
            and link.dh.d == 0.0
            and link.joint.type != "prismatic"
            and level(link.payload)
            and level(link.rigid)
            for link in scene.links
        )
        and all(flat(loop) for loop in scene.loops)
        and (isinstance(zeroed, str) or all(z.dof in ("x", "y", "rz") for z in zeroed))
    )


def stiffening(scene: Scene) -> bool:
    """Whether spin softens and stiffens the links: one effect, which needs the axial force."""
    return bool(scene.effects.centrifugal and scene.effects.axial)


def watch_limits(scene: Scene) -> np.ndarray:
    """(6, 2) of the scene's validity: warn and stop, infinite where there is none."""
    v = scene.validity
    rows = [v.elastic_rotation, v.spin_ratio, v.correction, v.axial_load, v.erls_condition, v.mass_condition]
    limits = np.array([[np.inf if x is None else x for x in (row.warn, row.stop)] for row in rows])
    if stiffening(scene):
        limits[1], limits[3, 1] = np.inf, np.inf
    return limits


def slender_limits(scene: Scene, link: Link, beyond: float, planar: bool) -> tuple[float, float]:
    """First bending frequency (rad/s) and buckling load (N) of a link as a cantilever; zero for a rigid one.

    `beyond` is the mass (kg) at its end.  The frequency is the root of
    1 + cos k cosh k + mu k (cos k sinh k - sin k cosh k) = 0 with mu = beyond / mass
    (Blevins, Formulas for Natural Frequency and Mode Shape, 1979,
    table 8-8), the load pi^2 E I / (4 L^2); both with the weaker of the bendings that are on.
    """
    effects, beam = scene.effects, link.beam
    bends_y = effects.bending_y and not planar
    if beam is None or not link.flexible or not (bends_y or effects.bending_z):
        return 0.0, 0.0
    s = section(beam)
    weaker = min(i for i, on in ((s.iz, effects.bending_z), (s.iy, bends_y)) if on)
    mass = beam.density * s.area * link.length
    mu = beyond / mass

    def characteristic(k: float) -> float:
        c, h, sn, sh = np.cos(k), np.cosh(k), np.sin(k), np.sinh(k)
        return float(1.0 + c * h + mu * k * (c * sh - sn * h))

    k = brentq(characteristic, 1e-6, 1.8752)
    rigidity = beam.youngs_modulus * weaker
    load = np.pi**2 * rigidity / (4.0 * link.length**2) if effects.axial else 0.0
    return float(k**2 * np.sqrt(rigidity / (mass * link.length**3))), load


def link_mass(link: Link) -> float:
    """Mass of a link with its bodies, kg."""
    own = link.beam.density * section(link.beam).area * link.length if link.beam else 0.0
    return own + sum(body.mass for body in (link.rigid, link.payload) if body)


def element_row(scene: Scene, link: Link, n: int, length: float, flexible: bool) -> np.ndarray:
    """Column values of element n of a link (see beam.py)."""
    row = np.zeros(COLUMNS)
    effects = scene.effects
    row[START], row[LENGTH] = n * length, length
    beam = link.beam
    if beam is None:
        return row
    s = section(beam)
    shear_modulus = beam.youngs_modulus / (2.0 * (1.0 + beam.poissons_ratio))
    row[MASS] = beam.density * s.area * length
    if effects.rotary_inertia:
        row[INERTIA_Y], row[INERTIA_Z] = beam.density * s.iz, beam.density * s.iy
    elif effects.torsion:
        row[POLAR] = beam.density * (s.iy + s.iz)
    if not flexible:
        return row
    row[TORSION] = shear_modulus * s.j / length
    row[AXIAL] = beam.youngs_modulus * s.area / length
    row[BEND_Z] = beam.youngs_modulus * s.iz / length
    row[BEND_Y] = beam.youngs_modulus * s.iy / length
    if effects.shear:
        phi_z = 12.0 * beam.youngs_modulus * s.iz / (shear_modulus * s.shear_area_y * length**2)
        phi_y = 12.0 * beam.youngs_modulus * s.iy / (shear_modulus * s.shear_area_z * length**2)
        row[SHEAR_Z], row[SHEAR_Y] = phi_z / (1.0 + phi_z), phi_y / (1.0 + phi_y)
    row[STIFFENING] = 1.0 if stiffening(scene) else 0.0
    return row


def element_matrices(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(12, 12) mass and stiffness of an element, nodes ordered (end, start)."""
    units = np.eye(12)
    centre = np.zeros((12, 4, 3))
    turn = np.zeros((12, 3, 3))
    stiffness = np.zeros((12, 12))
    for k in range(12):
        end, start = units[k, :6].copy(), units[k, 6:].copy()
        spatial_beam.centreline(row, start, end, 0.0, centre[k])
        spatial_beam.section_rotation(row, start, end, turn[k])
        force = np.zeros((2, 6))
        nodes = np.array([start, end])
        spatial_beam.stiffness_product(row, np.zeros((2, 6)), nodes, 1, 1.0, force)
        stiffness[k] = np.concatenate([force[1], force[0]])
    mass = row[MASS] * np.einsum("iak,ab,jbk->ij", centre, HERMITE_MASS, centre)
    zero = np.zeros((12, 3))
    x, y, z = turn[:, :, 0], turn[:, :, 1], turn[:, :, 2]
    for inertia, director in ((row[INERTIA_Y], (-z, zero, x)), (row[INERTIA_Z], (y, -x, zero))):
        for part in director:
            mass += inertia * row[LENGTH] * part @ QUADRATIC_MASS @ part.T
    linear = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    for i, p in enumerate((9, 3)):
        for k, q in enumerate((9, 3)):
            mass[p, q] += row[POLAR] * row[LENGTH] * linear[i, k]
    return mass, stiffness


def own_matrix(matrix: np.ndarray) -> np.ndarray:
    """(B, B) of a (2B, 2B) matrix of nodes (end, start), over an element's unknowns (see co_moving.py)."""
    b = len(matrix) // 2
    rows = np.zeros((2 * b, b))
    if b == 3:
        # u, start -b, end c
        rows[0, 0] = rows[2, 2] = 1.0
        rows[5, 1] = -1.0
    else:
        rows[0, 0] = rows[4, 4] = rows[5, 5] = 1.0
        rows[10, 2] = rows[11, 1] = -1.0
        rows[3, 3], rows[9, 3] = 0.5, -0.5
    return rows.T @ matrix @ rows


def follow(dofs: list[int], comp: int, length: float) -> np.ndarray:
    """(12,) dependency of a dof that moves with the node before as with a rigid body."""
    row = np.zeros(12)
    row[6 + comp] = 1.0
    if comp == 1:
        row[6 + 5] = length
    if comp == 2:
        row[6 + 4] = -length
    return row


def build_model(scene: Scene, planar: bool | None = None, driven: tuple[str, ...] = ()) -> Model:
    """Build the arrays of a scene's equations.

    Parameters
    ----------
    planar : three dofs a node where True, six where False; found from the scene where None
    driven : names of the joints whose motion is prescribed

    Raises
    ------
    SceneError
        where the zeroed dofs don't define the ERLS
    """
    decision = None
    if scene.effects.undecided:
        decision = resolve_effects(scene)
        scene = decision.scene
    if planar is None:
        planar = is_planar(scene)
    effects = scene.effects
    dofs = PLANAR_DOFS if planar else list(range(6))
    b = len(dofs)
    both = dofs + [6 + k for k in dofs]
    links = len(scene.links)
    link_table = np.zeros((links, 10), dtype=np.int64)
    joint_table = np.zeros((links, 16))
    rotation = np.zeros((links, 3, 3, 3))
    axes = np.zeros((links, 3, 3))
    elements: list[np.ndarray] = []
    masses: list[np.ndarray] = []
    stiffnesses: list[np.ndarray] = []
    index: list[np.ndarray] = []
    dependency: list[np.ndarray] = []
    bodies: list[np.ndarray] = []
    body_masses: list[np.ndarray] = []
    body_nodes: list[int] = []
    places: list[float] = []
    stations: list[float] = []
    reductions: dict[int, ReducedLink] = {}
    node_link: list[int] = []
    node_names: list[str] = []
    joint_links: list[int] = []
    turns: list[int] = []
    motors: list[int] = []
    moving = sum(link.joint.type != "fixed" for link in scene.links)
    elastic_joints = effects.joint_elasticity and effects.rotor_inertia
    unknowns = moving + sum(elastic_joints and joint.stiffness is not None for joint in scene.joints)
    coordinates = unknowns
    moving_frames = scene.formulation == "co_moving"
    rooted = scene.model_copy(update={"erls": Erls(zeroed="root")})
    zeroed = zeroed_directions(rooted if moving_frames else scene, driven)
    spin = np.zeros((3, 3, 3))
    spin[0, 2, 2] = spin[1, 0, 0] = spin[1, 1, 1] = 1.0
    spin[2, 0, 1], spin[2, 1, 0] = -1.0, 1.0
    for n, (link, parent) in enumerate(zip(scene.links, scene.parents, strict=True)):
        before = axes[parent] if parent >= 0 else np.eye(3)
        axes[n], length = beam_axes(link)
        inside = rotation_x(link.dh.alpha) @ axes[n]
        for k in range(3):
            rotation[n, k] = before.T @ spin[k] @ inside
        joint = link.joint
        kind = {"fixed": FIXED, "revolute": REVOLUTE, "prismatic": PRISMATIC}[joint.type]
        joint_table[n, 0] = length
        joint_table[n, 1:4] = inside[2]
        joint_table[n, 4:7] = before[2]
        joint_table[n, 7] = link.dh.theta
        if effects.joint_friction:
            joint_table[n, 8:11] = joint.viscous_friction, joint.coulomb_friction, joint.coulomb_speed
        if effects.rotor_inertia:
            joint_table[n, 11] = joint.rotor_inertia * joint.gear_ratio**2
        flexible = link.flexible and link.beam is not None
        pieces = link.beam.elements if flexible and link.beam else (1 if length > 0.0 else 0)
        modes = scene.modes_of(link)
        count = pieces if modes is None else 1
        first = len(index)
        q = phi = motor = -1
        if kind != FIXED:
            q = len(joint_links)
            joint_links.append(n)
            if kind == REVOLUTE and (0, 5) not in zeroed[n]:
                phi = unknowns
                unknowns += 1
            turns.append(phi)
            if elastic_joints and joint.stiffness is not None:
                motor = moving + sum(k >= 0 for k in motors)
                joint_table[n, 12:14] = joint.stiffness, joint.damping
            motors.append(motor)
        link_table[n] = kind, q, phi, first, count, len(elements), parent, len(bodies), 0, motor
        step = length / count if count else 0.0
        for i in range(pieces + 1):
            node_link.append(n)
            node_names.append(f"{link.name}/{i}")
            stations.append(i * length / max(pieces, 1))
        free = [
            flexible and bool(on)
            for on in (
                effects.axial,
                effects.bending_z,
                effects.bending_y,
                effects.torsion,
                effects.bending_y,
                effects.bending_z,
            )
        ]
        for i in range(count + 1):
            places.append(i * step)
            row = np.full(6, -1, dtype=np.int64)
            depends = np.zeros((6, 12))
            if i > 0:
                for k in range(6):
                    if not free[k]:
                        depends[k] = follow(dofs, k, step)
                for (node, _), direction in zeroed[n].items():
                    if node == i:
                        k = int(np.argmax(np.abs(direction)))
                        depends[k] = np.concatenate([-direction / direction[k], np.zeros(6)])
                        depends[k, k] = 0.0
                        free_here = [*free]
                        free_here[k] = False
                        row[k] = -2
                for k in dofs:
                    if free[k] and row[k] != -2:
                        row[k] = unknowns
                        unknowns += 1
                row[row == -2] = -1
            index.append(row[dofs])
            dependency.append(depends[np.ix_(dofs, both)])
        if modes is not None:
            reductions[n] = reduction_of(scene, link, length, modes, free, planar)
            for i in range(0, len(reductions[n].modal_mass), b):
                row = np.full(b, -1, dtype=np.int64)
                here = min(b, len(reductions[n].modal_mass) - i)
                row[:here] = range(unknowns, unknowns + here)
                unknowns += here
                index.append(row)
                dependency.append(np.zeros((b, 2 * b)))
                places.append(0.0)
        for i in range(count):
            values = element_row(scene, link, i, step, flexible)
            if modes is not None:
                values[STIFFENING] = 0.0
            mass, stiffness = element_matrices(values)
            mass, stiffness = mass[np.ix_(both, both)], stiffness[np.ix_(both, both)]
            if moving_frames:
                values[START] = 0.0
                mass, stiffness = own_matrix(mass), own_matrix(stiffness)
            elements.append(values)
            masses.append(mass)
            stiffnesses.append(stiffness)
        for body in (link.rigid, link.payload):
            if body is None or body.mass == 0.0:
                continue
            inertia = np.array(body.inertia) if body.inertia else np.zeros((3, 3))
            matrix = pseudo_inertia(
                body.mass,
                axes[n].T @ np.array(body.center_of_mass),
                axes[n].T @ inertia @ axes[n],
            )
            bodies.append(matrix)
            body_masses.append(body_mass(matrix)[np.ix_(dofs, dofs)])
            body_nodes.append(first + count)
            link_table[n, 8] += 1
    beyond = np.zeros(links)
    for n in range(links - 1, -1, -1):
        beyond_end = beyond[n] + (scene.links[n].payload.mass if scene.links[n].payload else 0.0)
        joint_table[n, 14:16] = slender_limits(scene, scene.links[n], beyond_end, planar)
        if link_table[n, 6] >= 0:
            beyond[link_table[n, 6]] += beyond[n] + link_mass(scene.links[n])
    limits = watch_limits(scene)
    gravity = np.array(scene.gravity) if effects.gravity else np.zeros(3)
    rayleigh = (scene.damping.alpha, scene.damping.beta) if effects.damping else (0.0, 0.0)
    closing, anchor = closing_equations(scene, axes, planar)
    at_chords = scene.erls.zeroed in ("chord", "auto") and not driven and not moving_frames
    size = b if moving_frames else 2 * b
    reduced, modal = reduced_links(reductions, links, dofs)
    chain = Chain(
        dofs=tuple(dofs),
        loops=(len(scene.loops),) if scene.loops else (),
        co_moving=(1,) if moving_frames else (),
        reduction=(1,) if reductions else (),
        link=link_table,
        joint=joint_table,
        rotation=rotation,
        element=np.array(elements).reshape(-1, COLUMNS),
        mass=np.array(masses).reshape(-1, size, size),
        stiffness=np.array(stiffnesses).reshape(-1, size, size),
        unknown=np.array(index),
        dependency=np.array(dependency),
        body=np.array(bodies).reshape(-1, 4, 4),
        body_mass=np.array(body_masses).reshape(-1, b, b),
        body_place=np.array(body_nodes, dtype=np.int64),
        place=np.array(places),
        setting=np.array(
            [*gravity, *rayleigh, at_chords, effects.coriolis, stiffening(scene), coordinates], dtype=float
        ),
        limit=limits[:3].copy(),
        closing=closing,
        anchor=anchor,
        reduced=reduced,
        modal=modal,
    )
    arrays = {name: value for name, value in chain._asdict().items() if isinstance(value, np.ndarray)}
    constants: dict[str, Any] = {name: aligned(array) for name, array in arrays.items()}
    for array in constants.values():
        array.setflags(write=False)
    chain = by_reference(chain._replace(**constants))
    model = Model(
        scene=scene,
        chain=chain,
        joints=moving,
        unknowns=unknowns,
        planar=planar,
        axes=axes,
        node_link=np.array(node_link),
        node_names=tuple(node_names),
        first_node=np.searchsorted(node_link, range(links + 1)),
        station=np.array(stations),
        joint_links=np.array(joint_links, dtype=np.int64),
        turn=np.array(turns, dtype=np.int64),
        actuated=np.array([joint.actuated for joint in scene.joints]),
        motor=np.array(motors, dtype=np.int64),
        zeroed=zeroed,
        limits=limits,
        decision=decision,
    )
    condition = erls_condition(chain, zeroed, scene.start("position"))
    if not condition < CONDITION_LIMIT:
        raise SceneError(
            f"{scene.name}: erls.zeroed: J_0 is singular (condition {condition:.1e}) at the initial position:"
            " the zeroed dofs don't hold every joint; give root, or for each joint a dof that turns with it"
        )
    return model


def reduction_of(
    scene: Scene, link: Link, length: float, modes: int, free: list[bool], planar: bool
) -> ReducedLink:
    """Reduce a link to its ends and `modes` modes; refused where it has fewer dofs between its ends."""
    assert link.beam is not None
    count, flat = link.beam.elements, planar or is_planar(scene)
    most = (count - 1) * sum(free[k] for k in (PLANAR_DOFS if flat else range(6)))
    if modes > most:
        raise SceneError(
            f"{scene.name}: reduction.modes: is {modes}, but {link.name} has {most} dofs between its ends"
            f" ({count} elements{' in the plane' if flat else ''}); give at most {most}, or more elements"
        )
    rows = np.array([element_row(scene, link, i, length / count, True) for i in range(count)])
    masses, stiffnesses = zip(*(element_matrices(row) for row in rows), strict=True)
    whole = element_row(scene, link, 0, length, True)
    stiffening = bool(whole[STIFFENING] > 0.0)
    matrices = np.array(masses), np.array(stiffnesses)
    return reduce_link(
        whole, element_matrices(whole)[1], rows, *matrices, modes, free, planar, flat, stiffening
    )


def body_mass(matrix: np.ndarray) -> np.ndarray:
    """(6, 6) mass matrix of a body over the dofs of its node."""
    vectors = np.zeros((6, 4, 3))
    for k, unit in enumerate(np.eye(6)):
        body_vectors(unit, 0.0, 0.0, vectors[k])
    return np.einsum("iak,ab,jbk->ij", vectors, matrix, vectors)
