"""Natural frequencies of a robot by direct stiffness: a frame of beams assembled in the base frame.

Every section has three displacements and three rotations along the base axes; what rides rigidly on a
section (bodies, rigid links, links' offsets) follows it by lever arms.  Shape functions are solved for from
the beam's own differential equation.  Of flexsim_node only the section's constants are taken.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import Polynomial
from scipy.linalg import eigh, null_space

from flexsim_node.elements.section import section
from flexsim_node.scene.schema import Beam, Link, Scene

FREE = {"axial": [0], "torsion": [3], "bending_y": [2, 4], "bending_z": [1, 5]}  # effect to dofs, beam axes


def cross_matrix(v: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def lever(arm: np.ndarray) -> np.ndarray:
    """(6, 6) from the displacement and rotation of a point to those of one that rides at `arm` from it."""
    carried = np.eye(6)
    carried[:3, 3:] = -cross_matrix(arm)
    return carried


def bending(length: float, stiffness: float, shear: float) -> list[tuple[Polynomial, Polynomial]]:
    """Deflection and rotation for (w, t) at both ends of a beam that only its ends load.

    Of w = c0 + c1 x + c2 x2 + c3 x3, EI t'' = -GA (w' - t) leaves t = w' + EI / GA w'''.  `shear` is 1 / GA.
    """
    powers = [Polynomial.basis(k) for k in range(4)]
    turns = [w.deriv() + stiffness * shear * w.deriv(3) for w in powers]
    ends = [[w(0.0), t(0.0), w(length), t(length)] for w, t in zip(powers, turns, strict=True)]
    shapes = np.linalg.inv(np.array(ends).T).T
    return [
        (
            sum(c * w for c, w in zip(row, powers, strict=True)),
            sum(c * t for c, t in zip(row, turns, strict=True)),
        )
        for row in shapes
    ]


def product(a: Polynomial, b: Polynomial, length: float) -> float:
    return float((a * b).integ()(length))


@lru_cache(maxsize=1000)
def bending_matrices(length: float, stiffness: float, shear: float) -> tuple[np.ndarray, ...]:
    """(4, 4) integrals over a beam of curvatures, shear strains, deflections and rotations."""
    shapes = bending(length, stiffness, shear)
    found = np.zeros((4, 4, 4))
    for i, (w, t) in enumerate(shapes):
        for j, (v, r) in enumerate(shapes):
            found[0, i, j] = product(t.deriv(), r.deriv(), length)
            found[1, i, j] = product(w.deriv() - t, v.deriv() - r, length)
            found[2, i, j] = product(w, v, length)
            found[3, i, j] = product(t, r, length)
    return tuple(found)


def beam_matrices(beam: Beam, effects, length: float) -> tuple[np.ndarray, np.ndarray]:
    """(12, 12) stiffness and mass over both ends' displacements and rotations in beam axes."""
    s = section(beam)
    e = beam.youngs_modulus
    g = e / (2 * (1 + beam.poissons_ratio))
    stiffness, mass = np.zeros((12, 12)), np.zeros((12, 12))
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    even = np.array([[2.0, 1.0], [1.0, 2.0]])
    along, twist = [0, 6], [3, 9]
    stiffness[np.ix_(along, along)] = e * s.area / length * pair
    stiffness[np.ix_(twist, twist)] = g * s.j / length * pair
    mass[np.ix_(along, along)] = beam.density * s.area * length / 6 * even
    if effects.rotary_inertia or effects.torsion:
        mass[np.ix_(twist, twist)] = beam.density * (s.iy + s.iz) * length / 6 * even
    for dofs, sign, second, area in (
        ([1, 5, 7, 11], 1.0, s.iz, s.shear_area_y),
        ([2, 4, 8, 10], -1.0, s.iy, s.shear_area_z),
    ):
        give = 1.0 / (g * area) if effects.shear else 0.0
        curvature, sheared, deflection, turned = bending_matrices(length, e * second, give)
        signs = np.array([1.0, sign, 1.0, sign])
        k = e * second * curvature + (sheared / give if effects.shear else 0.0)
        m = beam.density * (s.area * deflection + (second * turned if effects.rotary_inertia else 0.0))
        both = np.ix_(dofs, dofs)
        stiffness[both] += signs[:, None] * k * signs
        mass[both] += signs[:, None] * m * signs
    return stiffness, mass


def frame_of(link: Link, start: np.ndarray, turn: np.ndarray, q: float):
    """Start of a link's beam, its end, turn of its end's frame, beam axes (columns) in the base frame."""
    dh, slides = link.dh, link.joint.type == "prismatic"
    theta = dh.theta + (0.0 if slides else q)
    start = start + turn[:, 2] * (q if slides else 0.0)
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(dh.alpha), np.sin(dh.alpha)
    axis = turn[:, 2]
    end_turn = turn @ np.array([[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0.0, sa, ca]])
    end = start + turn @ [dh.a * c, dh.a * s, dh.d]
    x = end - start
    if np.linalg.norm(x) < 1e-12:
        return start, end, end_turn, np.eye(3), axis
    x = x / np.linalg.norm(x)
    z = end_turn[:, 2] - (end_turn[:, 2] @ x) * x
    if np.linalg.norm(z) < 1e-9:
        z = end_turn[:, 0] - (end_turn[:, 0] @ x) * x
    z = z / np.linalg.norm(z)
    return start, end, end_turn, np.column_stack([x, np.cross(z, x), z]), axis


class Frame:
    """A scene's robot in one position, its joints locked or free."""

    def __init__(self, scene: Scene, position: np.ndarray, locked: bool = True) -> None:
        self.scene, self.locked = scene, locked
        self.columns = 0
        self.pending: list = []  # (row (6, columns so far), stiffness or mass to add)
        self.stiffness_terms: list[tuple[np.ndarray, np.ndarray]] = []
        self.mass_terms: list[tuple[np.ndarray, np.ndarray]] = []
        ends = {-1: (np.zeros(3), np.eye(3), np.zeros((6, 0)))}
        k = 0
        for n, link in enumerate(scene.links):
            base, turn, row = ends[scene.parents[n]]
            q = 0.0
            if link.joint.type != "fixed":
                q, k = position[k], k + 1
            start, end, end_turn, axes, axis = frame_of(link, base, turn, q)
            row = lever(start - base) @ row
            if link.joint.type != "fixed":
                row = self.joint(link, axis, row)
            ends[n] = end, end_turn, self.beam(link, start, end, axes, row)
            for body in (link.rigid, link.payload):
                if body is not None and body.mass > 0.0:
                    self.body(body, end_turn, ends[n][2])
        self.ends = ends

    def new(self) -> int:
        self.columns += 1
        return self.columns - 1

    def wide(self, row: np.ndarray) -> np.ndarray:
        """The row with a column for everything there is by now."""
        return np.hstack([row, np.zeros((len(row), self.columns - row.shape[1]))])

    def joint(self, link: Link, axis: np.ndarray, row: np.ndarray) -> np.ndarray:
        """The section behind a joint: what it gives way by, with its spring and its rotor."""
        joint, effects = link.joint, self.scene.effects
        sprung = joint.stiffness is not None and effects.joint_elasticity and effects.rotor_inertia
        turns = not self.locked or (not joint.actuated and bool(self.scene.loops))
        if not sprung and not turns:
            return row
        own = self.new()
        row = self.wide(row)
        row[3 if joint.type == "revolute" else 0 :, own][:3] = axis
        motor = np.zeros((1, self.columns))
        motor[0, own] = 1.0
        if sprung:
            spring = motor.copy()
            motor = np.zeros((1, self.columns))
            if turns:
                at = self.new()
                spring, motor, row = self.wide(spring), self.wide(motor), self.wide(row)
                motor[0, at] = 1.0
                spring[0, at] = -1.0
            self.stiffness_terms.append((spring, np.array([[joint.stiffness]])))
        if effects.rotor_inertia:
            self.mass_terms.append((motor, np.array([[joint.rotor_inertia * joint.gear_ratio**2]])))
        return row

    def beam(self, link: Link, start, end, axes: np.ndarray, row: np.ndarray) -> np.ndarray:
        """Elements from a link's start to its end; the row of the end."""
        whole = end - start
        if link.beam is None:
            return lever(whole) @ row
        flexible = link.flexible
        count = link.beam.elements if flexible else 1
        step = np.linalg.norm(whole) / count
        stiffness, mass = beam_matrices(link.beam, self.scene.effects, step)
        both = np.kron(np.eye(2), axes)
        free = [d for name, dofs in FREE.items() if getattr(self.scene.effects, name) for d in dofs]
        for _ in range(count):
            before = row
            row = lever(whole / count) @ row
            if flexible:
                for dof in free:
                    at = self.new()
                    row = self.wide(row)
                    row[3 * (dof // 3) : 3 * (dof // 3) + 3, at] += axes[:, dof % 3]
            pair = np.kron(np.eye(2), both.T) @ np.vstack([self.wide(before), self.wide(row)])
            self.mass_terms.append((pair, mass))
            if flexible:
                self.stiffness_terms.append((pair, stiffness))
        return row

    def body(self, body, turn: np.ndarray, row: np.ndarray) -> None:
        centre = lever(turn @ np.array(body.center_of_mass)) @ row
        inertia = np.zeros((6, 6))
        inertia[:3, :3] = body.mass * np.eye(3)
        if body.inertia is not None:
            inertia[3:, 3:] = turn @ np.array(body.inertia) @ turn.T
        self.mass_terms.append((centre, inertia))

    def closing(self) -> np.ndarray:
        """(R, n) rows of what closing joints hold together."""
        rows = []
        for loop in self.scene.loops:
            parts = []
            for name in loop.links:
                n = -1 if name == "base" else self.scene.link_names.index(name)
                _, turn, row = self.ends[n]
                parts.append(
                    (turn, lever(turn @ np.array(loop.point(name))) @ self.wide(row), loop.direction(name))
                )
            (turn_a, a, axis_a), (turn_b, b, axis_b) = parts
            apart = a - b
            if loop.joint == "slot":
                across = null_space((turn_b @ axis_b)[None]).T
                # the slot turns with its link: points of it ride there
                place_a = self.ends[self.scene.link_names.index(loop.links[0])]
                meet = place_a[0] + place_a[1] @ np.array(loop.point(loop.links[0]))
                n_b = -1 if loop.links[1] == "base" else self.scene.link_names.index(loop.links[1])
                rides = lever(meet - self.ends[n_b][0]) @ self.wide(self.ends[n_b][2])
                rows.append(across @ (a - rides)[:3])
                continue
            rows.append(apart[:3])
            if loop.joint == "revolute":
                rows.append(null_space((turn_a @ axis_a)[None]).T @ apart[3:])
            elif loop.joint == "universal":
                rows.append(np.cross(turn_a @ axis_a, turn_b @ axis_b)[None] @ apart[3:])
            elif loop.joint == "fixed":
                rows.append(apart[3:])
        return np.vstack(rows) if rows else np.zeros((0, self.columns))

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """(n, n) stiffness and mass over what is independent."""
        out = []
        for terms in (self.stiffness_terms, self.mass_terms):
            total = np.zeros((self.columns, self.columns))
            for row, matrix in terms:
                full = self.wide(row)
                total += full.T @ matrix @ full
            out.append(total)
        closing = self.closing()
        if len(closing):
            scale = np.linalg.norm(closing, axis=1, keepdims=True)
            ways = null_space(closing / scale, rcond=1e-10)
            out = [ways.T @ part @ ways for part in out]
        return out[0], out[1]

    def frequencies(self) -> np.ndarray:
        """Hz, rising."""
        stiffness, mass = self.matrices()
        if not len(mass):
            return np.zeros(0)
        found = eigh(stiffness, mass, eigvals_only=True)
        return np.sqrt(np.maximum(found, 0.0)) / (2 * np.pi)
