"""A robot with held joints as a frame of geometrically exact beams: its shape and frequencies under load.

Nodes have a place and a rotation matrix (Simo 1985). A beam is many two-node elements whose strains are taken
at the middle section, turned half-way between the end sections, so that rotations are finite and every load
finds its full geometric stiffness by itself. Bending that the middle section misses is given back by a shear
flexibility L^2 / (12 E I) (MacNeal 1978): a straight element then has the exact linear stiffness. Masses are
rigid bodies at the nodes. So the error falls with the second power of the element's length, and
`extrapolated` takes it away.

Equations: potential of strain, weight, dead forces and of a steady spin in the turning frame,

    V = sum 1/2 e.C e - sum m g.p - sum F.p - 1/2 sum (m |W x p|^2 + W.J W)

and the part of the kinetic energy linear in the rates, v.m(W x p) + w.J W, which gives the gyroscopic forces.
First derivatives are complex steps (exact to rounding), second ones five-point differences of them. Moments
with fixed directions have no potential and stand in the forces by themselves.

Nothing is taken from flexsim_node but the scene that it has read.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import LinAlgError, eig, eigh

from flexsim_node.scene.schema import Link, Scene

COMPLEX_STEP = 1e-30
DIFFERENCE = 2e-3  # rad and m, of the five-point differences
FIVE_POINTS = ((-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0))


def cross_matrices(v: np.ndarray) -> np.ndarray:
    """(..., 3, 3) matrices of v x, v (..., 3)."""
    out = np.zeros((*v.shape, 3), dtype=v.dtype)
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return out - np.swapaxes(out, -1, -2)


def exponentials(v: np.ndarray) -> np.ndarray:
    """(..., 3, 3) rotations by the vectors v (..., 3), also complex; by the series, below 0.5 rad."""
    square = np.sum(v * v, axis=-1)[..., None, None]
    first = term = np.ones_like(square)  # sin(a) / a
    second, other = 0.5 * first, 0.5 * first  # (1 - cos(a)) / a^2
    for k in range(1, 8):
        term = -term * square / (2 * k * (2 * k + 1))
        other = -other * square / ((2 * k + 1) * (2 * k + 2))
        first, second = first + term, second + other
    x = cross_matrices(v)
    return np.eye(3) + first * x + second * (v[..., :, None] * v[..., None, :] - square * np.eye(3))


def logarithms(r: np.ndarray) -> np.ndarray:
    """(..., 3) rotation vectors of r (..., 3, 3), also complex; for rotations below 0.2 rad."""
    s = np.stack([r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], -1)
    square = 0.25 * np.sum(s * s, axis=-1)  # of the sine; asin(x) / x by its series
    factor, term = np.ones_like(square), np.ones_like(square)
    for k in range(1, 13):
        term = term * square * ((2 * k - 1) / (2 * k))
        factor = factor + term / (2 * k + 1)
    return 0.5 * factor[..., None] * s


def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(..., 3) products of matrices and vectors."""
    return (matrix @ vector[..., None])[..., 0]


def torsion_constant(width: float, depth: float) -> float:
    """Saint-Venant's constant of a rectangle, m4."""
    a, b = max(width, depth), min(width, depth)
    k = np.arange(1, 60, 2)
    return float(a * b**3 * (1 / 3 - 64 / np.pi**5 * b / a * np.sum(np.tanh(0.5 * np.pi * k * a / b) / k**5)))


@dataclass
class Frame:
    """Nodes, elements and bodies; add them, then ask. All axes at the start are those of the base.

    Attributes
    ----------
    place : (N, 3) of the nodes, undeformed, m; node 0 is clamped
    elements : (start, end, offset at the start, at the end (3,), axes (3, 3) columns, length, (6,) stiffness
        N, shear y, shear z, torsion, bending y, bending z; 0 shear stiffness: none, as Euler and Bernoulli)
    bodies : (node, offset (3,), mass, (3, 3) inertia about its own centre)
    loads : (node, offset (3,), force (3,), moment (3,)), directions fixed
    bifilar : polar second moment over area, m2, of each element whose axial strain gets 1/2 (Ip / A) twist'^2
    """

    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    spin: np.ndarray = field(default_factory=lambda: np.zeros(3))
    place: list = field(default_factory=lambda: [np.zeros(3)])
    elements: list = field(default_factory=list)
    bodies: list = field(default_factory=list)
    loads: list = field(default_factory=list)
    bifilar: list = field(default_factory=list)

    def node(self, place: np.ndarray) -> int:
        """A further node."""
        self.place.append(np.array(place, dtype=float))
        return len(self.place) - 1

    def beam(
        self,
        start: int,
        offset: np.ndarray,
        axes: np.ndarray,
        length: float,
        count: int,
        stiffness: np.ndarray,
        line: tuple[float, float, float],
        bifilar: float = 0.0,
    ) -> int:
        """The node at the end of a beam of `count` elements that starts at an offset from node `start`.

        line : mass, and rotary inertia about the beam's y and z, each of a metre
        """
        step, before, shift = length / count, start, np.asarray(offset, dtype=float)
        mass = line[0] * step
        inertia = axes @ np.diag([line[1] + line[2], line[1], line[2]]) @ axes.T * step
        first = self.place[start] + shift
        for k in range(count):
            after = self.node(first + axes[:, 0] * step * (k + 1))
            self.elements.append((before, after, shift, np.zeros(3), axes, step, stiffness))
            self.bifilar.append(bifilar)
            for node, at in ((before, shift), (after, np.zeros(3))):
                self.bodies.append((node, at, 0.5 * mass, 0.5 * inertia))
            before, shift = after, np.zeros(3)
        return before

    def solved(self) -> Solution:
        """The frame at rest under its loads, or spinning steadily.

        Raises
        ------
        ArithmeticError
            where Newton's method finds no equilibrium
        """
        return Solution(self)


class Solution:
    """Equilibrium of a frame: `place` (N, 3), `turn` (N, 3, 3), and the matrices about it."""

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.place, self.turn = np.array(frame.place), np.tile(np.eye(3), (len(frame.place), 1, 1))
        e = frame.elements
        self.ends = np.array([x[:2] for x in e]).reshape(-1, 2)
        self.offset = [np.array([x[k] for x in e]).reshape(-1, 3) for k in (2, 3)]
        self.axes = np.array([x[4] for x in e]).reshape(-1, 3, 3)
        self.length = np.array([x[5] for x in e])
        self.stiffness = self._with_missed_bending(np.array([x[6] for x in e], dtype=float).reshape(-1, 6))
        self.body = np.array([x[0] for x in frame.bodies], dtype=int)
        self.arm = np.array([x[1] for x in frame.bodies]).reshape(-1, 3)
        self.mass = np.array([x[2] for x in frame.bodies])
        self.inertia = np.array([x[3] for x in frame.bodies]).reshape(-1, 3, 3)
        self.free = np.arange(6, 6 * len(self.place))
        self._settle()

    def _with_missed_bending(self, c: np.ndarray) -> np.ndarray:
        made = c.copy()
        for shear, bending in ((1, 5), (2, 4)):
            own = np.divide(1.0, c[:, shear], out=np.zeros(len(c)), where=c[:, shear] > 0.0)
            made[:, shear] = 1.0 / (own + self.length**2 / (12.0 * c[:, bending]))
        return made

    # ------------------------------------------------------------------ elements
    def _strains(self, d: np.ndarray) -> np.ndarray:
        """(..., E, 6) strains after the nodes moved on by d (..., E, 12): place and rotation of each end."""
        ends = []
        for k in (0, 1):
            nodes, own = self.ends[:, k], d[..., 6 * k : 6 * k + 6]
            turn = exponentials(own[..., 3:]) @ self.turn[nodes]
            ends.append((self.place[nodes] + own[..., :3] + times(turn, self.offset[k]), turn @ self.axes))
        (first, a), (last, b) = ends
        bend = logarithms(np.swapaxes(a, -1, -2) @ b)
        middle = a @ exponentials(0.5 * bend)
        stretch = times(np.swapaxes(middle, -1, -2), last - first) / self.length[:, None]
        stretch = stretch - np.array([1.0, 0.0, 0.0])
        bend = bend / self.length[:, None]
        along = stretch[..., :1] + 0.5 * (np.array(self.frame.bifilar) * bend[..., 0] ** 2)[..., None]
        return np.concatenate([along, stretch[..., 1:], bend], axis=-1)

    def _strain_slopes(self, d: np.ndarray) -> np.ndarray:
        """(..., E, 6, 12) derivatives of the strains."""
        return complex_derivatives(self._strains, d)

    # ------------------------------------------------------------------ bodies and loads
    def _jacobians(self, nodes: np.ndarray, arm: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, ...]:
        """Places (..., n, 3) and rotations (..., n, 3, 3) of points on nodes that moved on by d (..., n, 6);
        how both go on with d: (..., n, 3, 6), (..., n, 3, 6).
        """

        def moved(d: np.ndarray) -> np.ndarray:
            turn = exponentials(d[..., 3:]) @ self.turn[nodes]
            points = self.place[nodes] + d[..., :3] + times(turn, arm)
            return np.concatenate([points, turn.reshape(*turn.shape[:-2], 9)], axis=-1)

        at, slope = moved(d), complex_derivatives(moved, d)
        turn = at[..., 3:].reshape(*at.shape[:-1], 3, 3)
        rates = np.moveaxis(slope[..., 3:, :].reshape(*at.shape[:-1], 3, 3, 6), -1, -3)
        rates = rates @ np.swapaxes(turn, -1, -2)[..., None, :, :]
        omega = np.stack([rates[..., 2, 1], rates[..., 0, 2], rates[..., 1, 0]], axis=-2)
        return at[..., :3], turn, slope[..., :3, :], omega

    def _body_force(self, d: np.ndarray) -> np.ndarray:
        """(..., B, 6) forces of weight and spin on the bodies."""
        point, turn, along, about = self._jacobians(self.body, self.arm, d)
        w = self.frame.spin
        force = self.mass[:, None] * (self.frame.gravity - np.cross(w, np.cross(w, point)))
        momentum = turn @ self.inertia @ np.swapaxes(turn, -1, -2) @ w
        return work_on(along, force) + work_on(about, np.cross(momentum, w))

    def _momentum(self, d: np.ndarray) -> np.ndarray:
        """(..., B, 6) what the spin leaves linear in the rates of the bodies' motions."""
        point, turn, along, about = self._jacobians(self.body, self.arm, d)
        w = self.frame.spin
        angular = turn @ self.inertia @ np.swapaxes(turn, -1, -2) @ w
        return work_on(along, self.mass[:, None] * np.cross(w, point)) + work_on(about, angular)

    def _load_force(self, d: np.ndarray) -> np.ndarray:
        """(..., F, 6) forces of the loads."""
        nodes = np.array([x[0] for x in self.frame.loads])
        arm, force, moment = (np.array([x[k] for x in self.frame.loads]) for k in (1, 2, 3))
        _, _, along, about = self._jacobians(nodes, arm, d)
        return work_on(along, force) + work_on(about, moment)

    # ------------------------------------------------------------------ assembled
    def _groups(self):
        """Node lists and forces on them as functions of their motions, of bodies and of loads."""
        yield self.body, self._body_force
        if self.frame.loads:
            yield np.array([x[0] for x in self.frame.loads]), self._load_force

    def balance(self) -> tuple[np.ndarray, np.ndarray]:
        """Forces (n,) that are left, and their derivative (n, n), negative: the stiffness."""
        n = 6 * len(self.place)
        left, stiffness = np.zeros(n), np.zeros((n, n))
        zero = np.zeros((len(self.length), 12))
        if len(zero):
            scaled = self.stiffness * self.length[:, None]
            strain, slope = self._strains(zero), self._strain_slopes(zero)
            stress = scaled * strain
            own = np.einsum("eki,ek,ekj->eij", slope, scaled, slope)
            own += np.einsum("ek,ekij->eij", stress, differences(self._strain_slopes, zero))
            dofs = (6 * self.ends[:, :, None] + np.arange(6)).reshape(-1, 12)
            np.add.at(left, dofs, -np.einsum("eki,ek->ei", slope, stress))
            np.add.at(stiffness, (dofs[:, :, None], dofs[:, None, :]), own)
        for nodes, force in self._groups():
            zero = np.zeros((len(nodes), 6))
            dofs = 6 * nodes[:, None] + np.arange(6)
            np.add.at(left, dofs, force(zero))
            np.add.at(stiffness, (dofs[:, :, None], dofs[:, None, :]), -differences(force, zero))
        return left[self.free], stiffness[np.ix_(self.free, self.free)]

    def _settle(self) -> None:
        size = np.inf
        for _ in range(60):
            left, stiffness = self.balance()
            step = np.linalg.solve(stiffness, left)
            before, size = size, float(np.max(np.abs(step)))
            if not np.isfinite(size):
                break
            step *= min(1.0, 0.2 / size)
            self.place[1:] += step.reshape(-1, 6)[:, :3]
            self.turn[1:] = exponentials(step.reshape(-1, 6)[:, 3:]) @ self.turn[1:]
            if size < 1e-14 or (size < 1e-9 and size >= before):
                return
        raise ArithmeticError("no equilibrium of the frame found")

    def mass_and_gyroscopic(self) -> tuple[np.ndarray, np.ndarray]:
        """(n, n) mass, and (n, n) gyroscopic matrix of the spin."""
        n = 6 * len(self.place)
        mass, gyroscopic = np.zeros((n, n)), np.zeros((n, n))
        zero = np.zeros((len(self.body), 6))
        _, turn, along, about = self._jacobians(self.body, self.arm, zero)
        inertia = turn @ self.inertia @ np.swapaxes(turn, 1, 2)
        own = np.einsum("nki,n,nkj->nij", along, self.mass, along)
        own += np.einsum("nki,nkl,nlj->nij", about, inertia, about)
        curl = differences(self._momentum, zero)
        dofs = 6 * self.body[:, None] + np.arange(6)
        where = dofs[:, :, None], dofs[:, None, :]
        np.add.at(mass, where, own)
        np.add.at(gyroscopic, where, curl - np.swapaxes(curl, 1, 2))
        block = np.ix_(self.free, self.free)
        return mass[block], gyroscopic[block]

    def frequencies(self, count: int = 6) -> np.ndarray:
        """(count,) undamped natural frequencies about the equilibrium, Hz, rising.

        Raises
        ------
        ArithmeticError
            where a motion grows
        """
        _, stiffness = self.balance()
        mass, gyroscopic = self.mass_and_gyroscopic()
        if not np.any(gyroscopic) and np.abs(stiffness - stiffness.T).max() < 1e-9 * np.abs(stiffness).max():
            try:  # M y = z K y: the lowest are not drowned by the stiffest
                z = eigh(mass, 0.5 * (stiffness + stiffness.T), eigvals_only=True)[::-1]
            except LinAlgError as error:
                raise ArithmeticError("the equilibrium is not stable") from error
            return 0.5 / np.pi / np.sqrt(z[:count])
        n = len(mass)
        # M y + z G y + z^2 K y = 0 with motions as exp(t / z)
        a = np.block([[np.zeros((n, n)), np.eye(n)], [-mass, np.zeros((n, n))]])
        b = np.block([[np.eye(n), np.zeros((n, n))], [gyroscopic, stiffness]])
        z = eig(np.linalg.solve(b, a), right=False)
        z = z[np.argsort(-np.abs(z))]
        s = 1.0 / z[np.abs(z) > 0.0][: 2 * count + 6]
        if np.any(s.real > 1e-6 * np.abs(s)):
            raise ArithmeticError(f"the equilibrium is not stable: exp({s[np.argmax(s.real)]:g} t)")
        return np.sort(np.abs(s.imag))[::2][:count] / (2.0 * np.pi)


def work_on(jacobian: np.ndarray, force: np.ndarray) -> np.ndarray:
    """(..., k) generalized forces of force (..., 3), jacobian (..., 3, k)."""
    return times(np.swapaxes(jacobian, -1, -2), force)


def complex_derivatives(function: Callable[[np.ndarray], np.ndarray], about: np.ndarray) -> np.ndarray:
    """(..., n, k, d) derivatives of function (..., n, d) -> (..., n, k)."""
    count = about.shape[-1]
    steps = 1j * COMPLEX_STEP * np.eye(count).reshape(count, *([1] * (about.ndim - 1)), count)
    return np.moveaxis(function(about + steps).imag / COMPLEX_STEP, 0, -1)


def differences(function: Callable[[np.ndarray], np.ndarray], about: np.ndarray) -> np.ndarray:
    """(n, ..., d) derivatives of function (b, n, d) -> (b, n, ...) about (n, d), by five points."""
    steps = DIFFERENCE * np.eye(about.shape[-1])[:, None, :]
    slope = sum(weight * function(about + at * steps) for at, weight in FIVE_POINTS) / (12.0 * DIFFERENCE)
    return np.moveaxis(slope, 0, -1)


def extrapolated(of: Callable[[int], np.ndarray], count: int) -> np.ndarray:
    """What `of` (count of elements -> array) tends to: its error falls with the second power of 1/count."""
    coarse, fine = of(count), of(2 * count)
    return fine + (fine - coarse) / 3.0


# ---------------------------------------------------------------------- of a scene
def turned_z(angle: float) -> np.ndarray:
    """(3, 3) rotation about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def turned_x(angle: float) -> np.ndarray:
    """(3, 3) rotation about x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def frame_of_scene(
    scene: Scene,
    position: list[float],
    count: int,
    *,
    loaded: bool = True,
    spin: float = 0.0,
    wrench: dict[str, np.ndarray] | None = None,
) -> tuple[Frame, dict[str, tuple[int, np.ndarray]]]:
    """A scene with its joints held at `position`, each flexible link in `count` elements.

    loaded : whether its weight acts; spin : of everything about the base's z axis, rad/s
    wrench : {link: (6,)} force and moment on links' ends, base axes, directions fixed

    Returns the frame, and for each link the node that carries its end and how far from it the end is.
    """
    frame = Frame(gravity=np.array(scene.gravity) * float(loaded), spin=np.array([0.0, 0.0, spin]))
    ends: dict[str, tuple[int, np.ndarray]] = {"base": (0, np.zeros(3))}
    axes = {"base": np.eye(3)}
    held, before = iter(position), "base"
    for link in scene.links:
        parent = link.parent or before
        q = 0.0 if link.joint.type == "fixed" else next(held)
        revolute, slides = link.joint.type == "revolute", link.joint.type == "prismatic"
        node, start = ends[parent]
        start = start + axes[parent][:, 2] * (q if slides else 0.0)
        turned = axes[parent] @ turned_z(link.dh.theta + (q if revolute else 0.0))
        along = turned @ np.array([link.dh.a, 0.0, link.dh.d])
        own = turned @ turned_x(link.dh.alpha)
        length = float(np.linalg.norm(along))
        if link.beam is None:
            end = node, start + along
        else:
            x = along / length
            z = own[:, 2] - (own[:, 2] @ x) * x
            if np.linalg.norm(z) < 1e-9:
                z = own[:, 0] - (own[:, 0] @ x) * x
            z /= np.linalg.norm(z)
            beam_axes = np.column_stack([x, np.cross(z, x), z])
            stiffness, line, radius = section_of(scene, link)
            if link.flexible:
                part = count, stiffness, line, radius
                last = frame.beam(node, start, beam_axes, length, *part)
                end = last, np.zeros(3)
            else:
                mass = line[0] * length
                about = np.diag([(line[1] + line[2]) * length, line[1] * length, line[2] * length])
                about[[1, 2], [1, 2]] += mass * length**2 / 12.0
                frame.bodies.append((node, start + 0.5 * along, mass, beam_axes @ about @ beam_axes.T))
                end = node, start + along
        for body in (link.rigid, link.payload):
            if body is not None and body.mass > 0.0:
                inertia = np.zeros((3, 3)) if body.inertia is None else np.array(body.inertia)
                arm = end[1] + own @ np.array(body.center_of_mass)
                frame.bodies.append((end[0], arm, body.mass, own @ inertia @ own.T))
        ends[link.name], axes[link.name], before = end, own, link.name
    for name, load in (wrench or {}).items():
        frame.loads.append((*ends[name], np.array(load[:3], dtype=float), np.array(load[3:], dtype=float)))
    return frame, ends


def section_of(scene: Scene, link: Link) -> tuple[np.ndarray, tuple[float, float, float], float]:
    """Of a rectangle: stiffness (6,); mass and rotary inertia of a metre; polar second moment over area."""
    beam, effects = link.beam, scene.effects
    w, t = beam.width, beam.depth
    area, iy, iz = w * t, w * t**3 / 12.0, t * w**3 / 12.0
    young, shear = beam.youngs_modulus, beam.youngs_modulus / (2.0 * (1.0 + beam.poissons_ratio))
    nu = beam.poissons_ratio
    cowper = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu) if effects.shear is True else 0.0
    stiffness = np.array(
        [
            young * area,
            cowper * shear * area,
            cowper * shear * area,
            shear * torsion_constant(w, t),
            young * iy,
            young * iz,
        ]
    )
    turning = beam.density if effects.rotary_inertia is not False else 0.0
    return stiffness, (beam.density * area, turning * iy, turning * iz), (iy + iz) / area


def link_ends(solution: Solution, ends: dict[str, tuple[int, np.ndarray]]) -> np.ndarray:
    """(L, 3) where the links' ends stand."""
    found = [solution.place[n] + solution.turn[n] @ arm for name, (n, arm) in ends.items() if name != "base"]
    return np.array(found)
