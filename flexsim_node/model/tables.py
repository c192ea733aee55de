"""The arrays of a chain, filled link by link from the base on; unknowns are numbered as they come."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..compiled.aligned import aligned
from ..compiled.by_reference import by_reference
from ..elements.beam import COLUMNS, HELIX, START, STIFFENING, TURNING
from ..elements.element import element_matrices, element_row, own_matrix, stiffening
from ..elements.rigid_body import body_mass, pseudo_inertia
from ..scene.load import Scene, SceneError
from ..scene.schema import Erls, Joint, Link, Undecided
from .chain import (
    ANGLE,
    AXIS,
    BENDING,
    BODIES,
    BOWED,
    BUCKLING,
    COULOMB,
    COULOMB_SPEED,
    DAMPER,
    FIXED,
    PARENT,
    PARENT_AXIS,
    PRISMATIC,
    REVOLUTE,
    ROTOR,
    SPRING,
    TIP,
    VISCOUS,
    Chain,
)
from .dofs import PLANAR_DOFS, follow, is_planar
from .erls import beam_axes, joint_axis, mount, to_joint, zeroed_directions
from .limits import link_mass, slender_limits, watch_limits
from .loops import closing_equations
from .reduced.reduction import ReducedLink, reduce_link, reduced_links

KINDS = {"fixed": FIXED, "revolute": REVOLUTE, "prismatic": PRISMATIC}


class Tables:
    """What a chain's arrays and a model's tables are made of; attributes as in Model."""

    def __init__(self, scene: Scene, planar: bool, driven: tuple[str, ...]) -> None:
        if scene.undecided:
            raise Undecided(f"{scene.name}: {', '.join(scene.undecided)}: auto, and nothing has decided it")
        effects, links = scene.effects, len(scene.links)
        self.scene, self.planar = scene, planar
        self.dofs = PLANAR_DOFS if planar else list(range(6))
        self.both = self.dofs + [6 + k for k in self.dofs]
        self.co_moving = scene.co_moving
        self.at_chords = scene.erls.zeroed in ("chord", "auto") and not driven and not self.co_moving
        self.turning = stiffening(scene) and not self.co_moving
        rooted = scene.model_copy(update={"erls": Erls(zeroed="root")})
        self.zeroed = zeroed_directions(rooted if self.co_moving else scene, driven)
        self.limits = watch_limits(scene)
        self.joints = sum(link.joint.type != "fixed" for link in scene.links)
        self.elastic_joints = effects.joint_elasticity and effects.rotor_inertia
        springs = sum(self.elastic_joints and joint.stiffness is not None for joint in scene.joints)
        self.coordinates = self.unknowns = self.joints + springs

        self.link = np.zeros((links, 10), dtype=np.int64)
        self.joint = np.zeros((links, 17))
        self.rotation = np.zeros((links, 3, 3, 3))
        self.axes = np.zeros((links, 3, 3))
        self.elements: list[np.ndarray] = []
        self.masses: list[np.ndarray] = []
        self.stiffnesses: list[np.ndarray] = []
        self.index: list[np.ndarray] = []
        self.dependency: list[np.ndarray] = []
        self.places: list[float] = []
        self.bodies: list[np.ndarray] = []
        self.body_masses: list[np.ndarray] = []
        self.body_nodes: list[int] = []
        self.reductions: dict[int, ReducedLink] = {}
        self.node_link: list[int] = []
        self.node_names: list[str] = []
        self.stations: list[float] = []
        self.joint_links: list[int] = []
        self.turns: list[int] = []
        self.motors: list[int] = []

        for n, link in enumerate(scene.links):
            self._add_link(n, link)
        self._add_limits()

    def _add_link(self, n: int, link: Link) -> None:
        parent = self.scene.parents[n]
        length = self._add_frame(n, link, parent)
        flexible = link.flexible and link.beam is not None
        pieces = link.beam.elements if flexible and link.beam else (1 if length > 0.0 else 0)
        modes = self.scene.modes_of(link)
        count = pieces if modes is None else 1
        q, phi, motor = self._add_joint(n, link.joint)
        first, step = len(self.index), length / count if count else 0.0
        element, body = len(self.elements), len(self.bodies)
        self.link[n] = KINDS[link.joint.type], q, phi, first, count, element, parent, body, 0, motor
        for i in range(pieces + 1):
            self.node_link.append(n)
            self.node_names.append(f"{link.name}/{i}")
            self.stations.append(i * length / max(pieces, 1))
        free = self._free(flexible)
        for i in range(count + 1):
            self._add_node(n, i, step, free)
        if modes is not None:
            self._add_modes(n, link, length, modes, free)
        for i in range(count):
            self._add_element(link, i, step, flexible, modes is not None)
        self._add_bodies(n, link, first + count)

    def _add_frame(self, n: int, link: Link, parent: int) -> float:
        """The link's axes, and how its joint turns them; the beam's length, m."""
        before = self.axes[parent] if parent >= 0 else np.eye(3)
        self.axes[n], length = beam_axes(link)
        inside, start, axis = to_joint(link) @ self.axes[n], before.T @ mount(link), joint_axis(link)
        for k, part in enumerate(turn_about(axis)):
            self.rotation[n, k] = start @ part @ inside
        row = self.joint[n]
        row[TIP] = length
        flexible = link.flexible and link.beam is not None
        row[BOWED] = length if self.turning and not flexible else 0.0
        row[AXIS : AXIS + 3] = axis @ inside
        row[PARENT_AXIS : PARENT_AXIS + 3] = start @ axis
        row[ANGLE] = link.dh.theta
        return length

    def _add_joint(self, n: int, joint: Joint) -> tuple[int, int, int]:
        """Unknowns of the joint's coordinate, its own elastic rotation and its motor's angle, -1 for none."""
        effects, row = self.scene.effects, self.joint[n]
        if effects.joint_friction:
            row[VISCOUS], row[COULOMB] = joint.viscous_friction, joint.coulomb_friction
            row[COULOMB_SPEED] = joint.coulomb_speed
        if effects.rotor_inertia:
            row[ROTOR] = joint.rotor_inertia * joint.gear_ratio**2
        if joint.type == "fixed":
            return -1, -1, -1
        q, phi, motor = len(self.joint_links), -1, -1
        self.joint_links.append(n)
        if joint.type == "revolute" and (0, 5) not in self.zeroed[n]:
            phi = self._next()
        if self.elastic_joints and joint.stiffness is not None:
            motor = self.joints + sum(k >= 0 for k in self.motors)
            row[SPRING], row[DAMPER] = joint.stiffness, joint.damping
        self.turns.append(phi)
        self.motors.append(motor)
        return q, phi, motor

    def _next(self) -> int:
        self.unknowns += 1
        return self.unknowns - 1

    def _free(self, flexible: bool) -> list[bool]:
        """Which of a node's six dofs are free by the scene's effects."""
        e = self.scene.effects
        moves = e.axial, e.bending_z, e.bending_y, e.torsion, e.bending_y, e.bending_z
        return [flexible and bool(on) for on in moves]

    def _add_node(self, n: int, i: int, step: float, free: list[bool]) -> None:
        """Node i of link n: its dofs' unknowns, and on what those that are not free depend."""
        row = np.full(6, -1, dtype=np.int64)
        depends = np.zeros((6, 12))
        if i > 0:
            for k in range(6):
                if not free[k]:
                    depends[k] = follow(k, step)
            held = set()
            for (node, _), direction in self.zeroed[n].items():
                if node == i:
                    k = int(np.argmax(np.abs(direction)))
                    depends[k] = np.concatenate([-direction / direction[k], np.zeros(6)])
                    depends[k, k] = 0.0
                    held.add(k)
            for k in self.dofs:
                if free[k] and k not in held:
                    row[k] = self._next()
        self.places.append(i * step)
        self.index.append(row[self.dofs])
        self.dependency.append(depends[np.ix_(self.dofs, self.both)])

    def _add_modes(self, n: int, link: Link, length: float, modes: int, free: list[bool]) -> None:
        """The coordinates of a reduced link's modes, in rows as long as a node's."""
        b = len(self.dofs)
        reduction = self.reductions[n] = reduction_of(self.scene, link, length, modes, free, self.planar)
        for i in range(0, len(reduction.modal_mass), b):
            row = np.full(b, -1, dtype=np.int64)
            for k in range(min(b, len(reduction.modal_mass) - i)):
                row[k] = self._next()
            self.index.append(row)
            self.dependency.append(np.zeros((b, 2 * b)))
            self.places.append(0.0)

    def _add_element(self, link: Link, i: int, step: float, flexible: bool, reduced: bool) -> None:
        values = element_row(self.scene, link, i, step, flexible)
        if reduced:
            values[STIFFENING] = values[TURNING] = values[HELIX] = 0.0
        mass, stiffness = (matrix[np.ix_(self.both, self.both)] for matrix in element_matrices(values))
        if self.co_moving:
            values[START] = values[TURNING] = 0.0
            mass, stiffness = own_matrix(mass), own_matrix(stiffness)
        self.elements.append(values)
        self.masses.append(mass)
        self.stiffnesses.append(stiffness)

    def _add_bodies(self, n: int, link: Link, node: int) -> None:
        axes = self.axes[n]
        for body, center in link.bodies:
            inertia = np.array(body.inertia) if body.inertia else np.zeros((3, 3))
            matrix = pseudo_inertia(body.mass, axes.T @ center, axes.T @ inertia @ axes)
            self.bodies.append(matrix)
            self.body_masses.append(body_mass(matrix)[np.ix_(self.dofs, self.dofs)])
            self.body_nodes.append(node)
            self.link[n, BODIES] += 1

    def _add_limits(self) -> None:
        """Each link's first bending frequency and buckling load with what is beyond its end."""
        links = self.scene.links
        beyond = np.zeros(len(links))
        for n in range(len(links) - 1, -1, -1):
            link, parent = links[n], self.link[n, PARENT]
            at_end = beyond[n] + (link.payload.mass if link.payload else 0.0)
            limits = slender_limits(self.scene, link, at_end, self.planar)
            self.joint[n, BENDING], self.joint[n, BUCKLING] = limits
            if parent >= 0:
                beyond[parent] += beyond[n] + link_mass(link)

    def chain(self) -> Chain:
        """The compiled kernels' arrays, which nothing changes any more."""
        scene, effects, b = self.scene, self.scene.effects, len(self.dofs)
        gravity = np.array(scene.gravity) if effects.gravity else np.zeros(3)
        alpha, beta = (scene.damping.alpha, scene.damping.beta) if effects.damping else (0.0, 0.0)
        thesis = scene.damping.alpha_form == "thesis"
        rayleigh, relative = (alpha if thesis else 0.0, beta), 0.0 if thesis else alpha
        spins = stiffening(scene)
        closing, anchor = closing_equations(scene, self.axes, self.planar)
        size = b if self.co_moving else 2 * b
        rubbing = [n for n in self.joint_links if self.joint[n, COULOMB] > 0.0]
        reduced, modal = reduced_links(self.reductions, len(scene.links), self.dofs)
        chain = Chain(
            dofs=tuple(self.dofs),
            loops=(len(scene.loops),) if scene.loops else (),
            co_moving=(1,) if self.co_moving else (),
            reduction=(1,) if self.reductions else (),
            link=self.link,
            joint=self.joint,
            rotation=self.rotation,
            element=np.array(self.elements).reshape(-1, COLUMNS),
            mass=np.array(self.masses).reshape(-1, size, size),
            stiffness=np.array(self.stiffnesses).reshape(-1, size, size),
            unknown=np.array(self.index),
            dependency=np.array(self.dependency),
            body=np.array(self.bodies).reshape(-1, 4, 4),
            body_mass=np.array(self.body_masses).reshape(-1, b, b),
            body_place=np.array(self.body_nodes, dtype=np.int64),
            place=np.array(self.places),
            setting=np.array(
                [*gravity, *rayleigh, self.at_chords, effects.coriolis, spins, self.coordinates, relative],
                dtype=float,
            ),
            limit=self.limits[:3].copy(),
            closing=closing,
            anchor=anchor,
            reduced=reduced,
            modal=modal,
            rubbing=np.array(rubbing, dtype=np.int64),
        )
        arrays = {name: value for name, value in chain._asdict().items() if isinstance(value, np.ndarray)}
        constants: dict[str, Any] = {name: aligned(array) for name, array in arrays.items()}
        for array in constants.values():
            array.setflags(write=False)
        return by_reference(chain._replace(**constants))


def turn_about(axis: np.ndarray) -> np.ndarray:
    """(3, 3, 3) constant, cosine and sine part of a rotation about a unit vector (3,)."""
    x, y, z = axis
    along = np.outer(axis, axis)
    return np.array([along, np.eye(3) - along, [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]])


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
    ends, spins = element_matrices(whole)[1], stiffening(scene)
    matrices = np.array(masses), np.array(stiffnesses)
    return reduce_link(whole, ends, rows, *matrices, modes, free, planar, flat, spins)
