"""Natural frequencies of a robot under its weight: a corotational frame, assembled from one potential.

Sections turn by finite rotations, elements deform little about their chords (Crisfield 1990), bodies ride on
turned sections.  The potential's gradient is taken by complex steps and its Hessian by differences of that:
nothing is linearised by hand and no geometric stiffness is written down.  Of flexsim_node only the section's
constants are taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from direct_stiffness import beam_matrices, bending, frame_of
from scipy.linalg import eigh

from flexsim_node.elements.section import section
from flexsim_node.scene.schema import Scene

TINY = 1e-25  # of complex steps
STEP = 1e-6  # m or rad, of the Hessian's differences


def crossing(v: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of (..., 3)."""
    out = np.zeros((*v.shape, 3), dtype=v.dtype)
    for i, j, k, sign in (
        (0, 1, 2, -1),
        (0, 2, 1, 1),
        (1, 0, 2, 1),
        (1, 2, 0, -1),
        (2, 0, 1, -1),
        (2, 1, 0, 1),
    ):
        out[..., i, j] = sign * v[..., k]
    return out


def exponential(v: np.ndarray) -> np.ndarray:
    """(..., 3, 3) rotations of small rotation vectors, by the series."""
    s = np.sum(v * v, axis=-1)[..., None, None]
    x = crossing(v)
    first = 1 - s / 6 + s**2 / 120 - s**3 / 5040
    second = 0.5 - s / 24 + s**2 / 720 - s**3 / 40320
    return np.eye(3) + first * x + second * (x @ x)


def logarithm(r: np.ndarray) -> np.ndarray:
    """(..., 3) rotation vectors of small rotations, by the series of the arc sine."""
    v = 0.5 * np.stack(
        [r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], axis=-1
    )
    s = np.sum(v * v, axis=-1, keepdims=True)
    return v * (1 + s / 6 + 3 * s**2 / 40 + 5 * s**3 / 112 + 35 * s**4 / 1152)


def times(r: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.einsum("...ij,...j->...i", r, v)


@dataclass
class Element:
    """A beam element between two sections, numbers into Frame's list."""

    start: int
    end: int
    axes: np.ndarray
    length: float
    stiffness: np.ndarray
    mass: np.ndarray
    axial: float
    line_mass: float
    slopes: list  # of both planes: (dofs of the rotations, signs, (2, 2) mean products of slopes, (2,) areas)


class LoadedFrame:
    """A scene's open chain or tree in one position, motors held."""

    def __init__(self, scene: Scene, position: np.ndarray) -> None:
        assert not scene.loops
        self.scene, self.count = scene, 0
        self.unloaded: np.ndarray | None = None
        self.sections: list = []  # how each follows: ("ride", of, arm), ("free", first dof, place), ...
        self.elements: list[Element] = []
        self.bodies: list = []  # (section, mass, arm, inertia)
        self.springs: list = []  # (dof, stiffness)
        ends = {-1: (np.zeros(3), np.eye(3), self.add(("fixed", np.zeros(3))))}
        k = 0
        for n, link in enumerate(scene.links):
            base, turn, at = ends[scene.parents[n]]
            q = 0.0
            if link.joint.type != "fixed":
                q, k = position[k], k + 1
            start, end, end_turn, axes, axis = frame_of(link, base, turn, q)
            at = self.add(("ride", at, start - base))
            joint = link.joint
            if joint.stiffness is not None and scene.effects.joint_elasticity and scene.effects.rotor_inertia:
                at = self.add((joint.type, at, axis, self.count))
                self.springs.append((self.count, joint.stiffness))
                self.count += 1
            at = self.beam(link, start, end, axes, at)
            ends[n] = end, end_turn, at
            for body in (link.rigid, link.payload):
                if body is not None and body.mass > 0.0:
                    inertia = np.zeros((3, 3)) if body.inertia is None else np.array(body.inertia)
                    arm = end_turn @ np.array(body.center_of_mass)
                    self.bodies.append((at, body.mass, arm, end_turn @ inertia @ end_turn.T))

    def add(self, rule) -> int:
        self.sections.append(rule)
        return len(self.sections) - 1

    def beam(self, link, start, end, axes, at: int) -> int:
        whole, beam = end - start, link.beam
        if beam is None:
            return self.add(("ride", at, whole))
        s, length = section(beam), float(np.linalg.norm(whole))
        line = beam.density * s.area
        if not link.flexible:
            # a rigid beam is a body
            mass = line * length
            about = beam.density * length * np.diag([s.iy + s.iz, s.iy, s.iz])
            if not self.scene.effects.rotary_inertia:
                about = np.diag(np.diag(about) * [1.0 if self.scene.effects.torsion else 0.0, 0.0, 0.0])
            about = about + mass * length**2 / 12 * np.diag([0.0, 1.0, 1.0])
            last = self.add(("ride", at, whole))
            self.bodies.append((last, mass, -0.5 * whole, axes @ about @ axes.T))
            return last
        step = length / beam.elements
        stiffness, mass = beam_matrices(beam, self.scene.effects, step)
        g = beam.youngs_modulus / (2 * (1 + beam.poissons_ratio))
        slopes = []
        for dofs, sign, second, area in (
            ([5, 11], 1.0, s.iz, s.shear_area_y),
            ([4, 10], -1.0, s.iy, s.shear_area_z),
        ):
            give = 1.0 / (g * area) if self.scene.effects.shear else 0.0
            shapes = [w for w, _ in bending(step, beam.youngs_modulus * second, give)][1::2]
            mean = [[float((a.deriv() * b.deriv()).integ()(step)) / step for b in shapes] for a in shapes]
            slopes.append((dofs, sign, np.array(mean), np.array([float(a.integ()(step)) for a in shapes])))
        for k in range(beam.elements):
            last = self.add(("free", self.count, start + whole * (k + 1) / beam.elements))
            self.count += 6
            self.elements.append(
                Element(at, last, axes, step, stiffness, mass, beam.youngs_modulus * s.area, line, slopes)
            )
            at = last
        return at

    def places(self, z: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Of every section: place (B, 3) and rotation (B, 3, 3) from the undeformed robot, at z (B, n)."""
        out: list[tuple[np.ndarray, np.ndarray]] = []
        many = len(z)
        for rule in self.sections:
            if rule[0] == "fixed":
                out.append(
                    (
                        np.tile(rule[1], (many, 1)).astype(z.dtype),
                        np.tile(np.eye(3), (many, 1, 1)) + 0 * z[0, 0],
                    )
                )
            elif rule[0] == "ride":
                p, r = out[rule[1]]
                out.append((p + times(r, rule[2]), r))
            elif rule[0] == "free":
                at = rule[1]
                out.append((rule[2] + z[:, at : at + 3], exponential(z[:, at + 3 : at + 6])))
            else:
                p, r = out[rule[1]]
                way = z[:, rule[3]][:, None] * rule[2]
                out.append((p, r @ exponential(way)) if rule[0] == "revolute" else (p + times(r, way), r))
        return out

    def element_frame(self, e: Element, places):
        """(B, 3, 3) axes of a deformed element, and its length."""
        (pa, ra), (pb, rb) = places[e.start], places[e.end]
        chord = pb - pa
        length = np.sqrt(np.sum(chord * chord, axis=-1))
        x = chord / length[:, None]
        middle = ra @ exponential(0.5 * logarithm(np.swapaxes(ra, 1, 2) @ rb))
        y = times(middle, e.axes[:, 1])
        y = y - np.sum(y * x, axis=-1)[:, None] * x
        y = y / np.sqrt(np.sum(y * y, axis=-1))[:, None]
        return np.stack([x, y, np.cross(x, y)], axis=-1), length

    def potential(self, z: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        """(B,) strain energy and height's, J."""
        places = self.places(z)
        total = np.zeros(len(z), dtype=z.dtype)
        for e in self.elements:
            axes, length = self.element_frame(e, places)
            back = np.swapaxes(axes, 1, 2)
            d = np.zeros((len(z), 12), dtype=z.dtype)
            d[:, 3:6] = logarithm(back @ places[e.start][1] @ e.axes)
            d[:, 9:12] = logarithm(back @ places[e.end][1] @ e.axes)
            stretch = length / e.length - 1.0
            bent = np.zeros((len(z), 3), dtype=z.dtype)  # integral of the deflection from the chord
            for (dofs, sign, mean, areas), axis in zip(e.slopes, (1, 2), strict=True):
                turns = sign * d[:, dofs]
                stretch = stretch + 0.5 * np.einsum("bi,ij,bj->b", turns, mean, turns)
                bent[:, axis] = turns @ areas
            total = total + 0.5 * np.einsum("bi,ij,bj->b", d, e.stiffness, d)
            total = total + 0.5 * e.axial * e.length * stretch**2
            middle = 0.5 * e.length * (places[e.start][0] + places[e.end][0]) + times(axes, bent)
            total = total - e.line_mass * middle @ gravity
        for at, mass, arm, _ in self.bodies:
            p, r = places[at]
            total = total - mass * (p + times(r, arm)) @ gravity
        for dof, stiffness in self.springs:
            total = total + 0.5 * stiffness * z[:, dof] ** 2
        return total

    def gradient(self, z: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        """(B, n) at z (B, n)."""
        many, n = z.shape
        away = (z[:, None, :] + 1j * TINY * np.eye(n)).reshape(-1, n)
        return self.potential(away, gravity).imag.reshape(many, n) / TINY

    def hessian(self, z: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        unit = STEP * np.eye(self.count)
        found = (self.gradient(z + unit, gravity) - self.gradient(z - unit, gravity)) / (2 * STEP)
        return 0.5 * (found + found.T)

    def mass(self, z: np.ndarray) -> np.ndarray:
        """(n, n) at z (n,)."""
        n = self.count
        moved = self.places(z + 1j * TINY * np.eye(n))
        rates = []
        for p, r in moved:
            spin = (r.imag / TINY) @ np.swapaxes(r.real, 1, 2)
            rates.append(
                np.hstack([p.imag / TINY, np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], -1)])
            )
        total = np.zeros((n, n))
        for e in self.elements:
            axes = self.element_frame(e, [(p.real, r.real) for p, r in moved])[0][0]
            both = np.hstack([rates[e.start], rates[e.end]]) @ np.kron(np.eye(4), axes)
            total += both @ e.mass @ both.T
        for at, mass, arm, inertia in self.bodies:
            turn = moved[at][1][0].real
            v, spin = rates[at][:, :3], rates[at][:, 3:]
            v = v + np.cross(spin, turn @ arm)
            total += mass * v @ v.T + spin @ turn @ inertia @ turn.T @ spin.T
        return total

    def squared(self, load: float) -> np.ndarray:
        """(n,) squared angular frequencies about the rest under `load` times the scene's gravity."""
        gravity = load * np.array(self.scene.gravity)
        z = np.zeros(self.count)
        if self.unloaded is None:
            self.unloaded = self.hessian(z, 0.0 * gravity)
        stiffness = self.unloaded
        for _ in range(4):
            z = z - np.linalg.solve(stiffness, self.gradient(z[None], gravity)[0])
            stiffness = self.hessian(z, gravity)
        return eigh(stiffness, self.mass(z), eigvals_only=True)
