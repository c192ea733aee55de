"""The robot's equations by another road: Lagrange's equations of sampled points of the displaced
chain.

Every element is filled with Gauss points (x, y, z) of the field

    p = o_l(q) + R_l(q) (x + N(x, y, z) d_l),    d_l = T_l(q, u)

to second order in u (docs/theory/second_order.md), built with 4 x 4 Denavit-Hartenberg matrices in the
base frame.  Kinetic energy is the sum over the points,
strain energy that of the strains at the Gauss points.  Derivatives are taken by complex steps,
which are
exact to rounding; nothing here knows of angular velocities, mass matrices or recursions, and
nothing but
the scene and the section constants is taken from flexsim_node.

Coordinates, in the order of flexsim's unknowns: the joints' q; then link by link the joint's own
elastic
rotation (where it is not zeroed) and the free dofs of nodes 1, 2, ... in beam axes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexsim_node.elements.section import section
from flexsim_node.scene.schema import Link, Scene

STEP = 1e-30  # of the complex derivative; no difference is taken, so it can be this small
GAUSS, WEIGHT = np.polynomial.legendre.leggauss(6)


def cross_matrix(v: np.ndarray) -> np.ndarray:
    """(3, 3) matrix of v x."""
    x, y, z = v
    return np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])


class Moving:
    """A vector or matrix with its rate, product rule included."""

    def __init__(self, value, rate=None):
        self.value = np.asarray(value)
        self.rate = np.zeros(self.value.shape) if rate is None else np.asarray(rate)

    def __matmul__(self, other):
        return Moving(self.value @ other.value, self.rate @ other.value + self.value @ other.rate)

    def __add__(self, other):
        return Moving(self.value + other.value, self.rate + other.rate)

    @property
    def T(self):
        return Moving(self.value.T, self.rate.T)


def squared(form, moving: Moving) -> Moving:
    """form(v, v) of a bilinear form, with its rate."""
    v, r = moving.value, moving.rate
    return Moving(form(v, v), form(v, r) + form(r, v))


def axes_turned(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3, 3) columns: what a turn s has of second order in the images of e_x, e_y, e_z, for a = b = s."""
    xx, yy, zz = a[0] * b[0], a[1] * b[1], a[2] * b[2]
    xy, xz, yz = a[0] * b[1], a[0] * b[2], 0.5 * a[1] * b[2]
    zero = 0 * xx
    return np.array([[-0.5 * (yy + zz), xy, xz], [zero, -0.5 * (xx + zz), yz], [zero, yz, -0.5 * (xx + yy)]])


def vector_from_slopes(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) how the rotation vector differs from the slopes s = a = b."""
    return 0.5 * a[0] * np.array([0 * b[0], b[2], -b[1]])


def rotation_z(angle, rate) -> Moving:
    c, s = np.cos(angle), np.sin(angle)
    zero = 0 * c
    return Moving(
        [[c, -s, zero], [s, c, zero], [zero, zero, zero + 1]],
        np.array([[-s, -c, zero], [c, -s, zero], [zero, zero, zero]]) * rate,
    )


def rotation_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def shape(xi: float, length: float, phi: float) -> tuple[np.ndarray, ...]:
    """Deflection, slope, rotation, curvature for (w1, t1, w2, t2) (Przemieniecki 1968, section
    11.3).
    """
    k = 1.0 / (1.0 + phi)
    w = k * np.array(
        [
            1 - 3 * xi**2 + 2 * xi**3 + phi * (1 - xi),
            length * (xi - 2 * xi**2 + xi**3 + 0.5 * phi * (xi - xi**2)),
            3 * xi**2 - 2 * xi**3 + phi * xi,
            length * (-(xi**2) + xi**3 - 0.5 * phi * (xi - xi**2)),
        ]
    )
    slope = (k / length) * np.array(
        [
            -6 * xi + 6 * xi**2 - phi,
            length * (1 - 4 * xi + 3 * xi**2 + 0.5 * phi * (1 - 2 * xi)),
            6 * xi - 6 * xi**2 + phi,
            length * (-2 * xi + 3 * xi**2 - 0.5 * phi * (1 - 2 * xi)),
        ]
    )
    turn = k * np.array(
        [
            6 * (xi**2 - xi) / length,
            1 - 4 * xi + 3 * xi**2 + phi * (1 - xi),
            6 * (xi - xi**2) / length,
            -2 * xi + 3 * xi**2 + phi * xi,
        ]
    )
    curvature = (k / length) * np.array(
        [
            6 * (2 * xi - 1) / length,
            -4 + 6 * xi - phi,
            6 * (1 - 2 * xi) / length,
            -2 + 6 * xi + phi,
        ]
    )
    return w, slope, turn, curvature


Y_PLANE = [1, 5, 7, 11]  # of (12,): uy, rz of both nodes
Z_PLANE = [2, 4, 8, 10]
Z_SIGN = np.array([1.0, -1.0, 1.0, -1.0])


@dataclass
class Element:
    """Constant matrices of one element over its 12 nodal dofs (start, end)."""

    points: np.ndarray  # (P, 3) undeformed, beam axes
    field: np.ndarray  # (P, 3, 12)
    mass: np.ndarray  # (P,)
    strains: list = field(default_factory=list)  # (stiffness, (12,) linear part)
    axial: tuple | None = None  # stiffness, (12,), list of (weight, slope (12,))
    spin: list = field(default_factory=list)  # (inertia, (12,) twist)
    shift: np.ndarray | None = None  # (12, 12): quadratic form of how the mass moves along the beam
    arm: np.ndarray | None = (
        None  # (P, 3) of a rigid body's points from its node, where it turns to second order
    )
    sections: list = field(default_factory=list)  # (end, second moments along y and z) that turn so
    turning: tuple | None = None  # stiffnesses (5,), length, shear shares: strains to second order

    def displacement(self, d: Moving) -> Moving:
        """(P, 3) of the points, for nodal rows d (12,)."""
        value, rate = self.field @ d.value, self.field @ d.rate
        if self.shift is not None:
            along = np.array([1.0, 0.0, 0.0])
            value = value + (d.value @ self.shift @ d.value) * along
            rate = rate + 2.0 * (d.value @ self.shift @ d.rate) * along
        if self.arm is not None:
            turned = squared(axes_turned, Moving(d.value[9:], d.rate[9:]))
            value, rate = value + self.arm @ turned.value.T, rate + self.arm @ turned.rate.T
        return Moving(value, rate)

    def turning_strains(self, d: Moving) -> Moving:
        """(5,) strains to second order of nodal rows d (12,), times the roots of their stiffnesses."""
        stiffness, length, (sz, sy) = self.turning
        oz, oy = 1 - sz, 1 - sy

        def linear(v):
            mz, my = 0.5 * (v[5] + v[11]), -0.5 * (v[4] + v[10])
            cz, cy = v[11] - v[5], v[4] - v[10]
            return cz, (v[7] - v[1]) / length - mz, mz, cy, (v[8] - v[2]) / length - my, my, v[3], v[9]

        def second(a, b):
            # products of the twist of a with the bending of b, and of both bendings
            _, _, _, _, _, _, start, end = linear(a)
            cz, dz, _, cy, dy, _, _, _ = linear(b)
            x0, x1 = 0.5 * (start + end), 0.5 * (end - start)
            az, sz_, mz, _, _, _, _, _ = linear(a)
            _, _, _, by, sy_, my, _, _ = linear(b)
            return np.array(
                [
                    x0 * cy - 2 * oy * x1 * dy,
                    x0 * dy - x1 * cy / 6,
                    -x0 * cz + 2 * oz * x1 * dz,
                    -x0 * dz + x1 * cz / 6,
                    (0.5 * my + oy * sy_) * az - (0.5 * mz + oz * sz_) * by,
                ]
            )

        def first(v):
            cz, dz, _, cy, dy, _, start, end = linear(v)
            return np.array([cz, dz, cy, dy, end - start])

        more, root = squared(second, d), np.sqrt(stiffness)
        return Moving(root * (first(d.value) + more.value), root * (first(d.rate) + more.rate))


def beam_axes(link: Link) -> tuple[np.ndarray, np.ndarray]:
    """Vector along the link and beam axes (columns), in the link's frame."""
    dh = link.dh
    along = rotation_x(dh.alpha).T @ [dh.a, 0.0, dh.d]
    length = np.linalg.norm(along)
    if length == 0.0:
        return along, np.eye(3)
    x = along / length
    z = np.array([0.0, 0.0, 1.0])
    if np.linalg.norm(np.cross(z, x)) < 1e-9:
        z = np.array([1.0, 0.0, 0.0])
    y = np.cross(z, x)
    y /= np.linalg.norm(y)
    return along, np.column_stack([x, y, np.cross(x, y)])


def build_element(
    scene: Scene, link: Link, start: float, length: float, flexible: bool, turns: bool = True
) -> Element:
    """`turns`: whether strains and sections turn to second order where the squared slope stretches."""
    beam, effects = link.beam, scene.effects
    s = section(beam)
    e_modulus = beam.youngs_modulus
    g_modulus = e_modulus / (2 * (1 + beam.poissons_ratio))
    phi_y = phi_z = 0.0
    if effects.shear and flexible:
        phi_z = 12 * e_modulus * s.iz / (g_modulus * s.shear_area_y * length**2)
        phi_y = 12 * e_modulus * s.iy / (g_modulus * s.shear_area_z * length**2)
    points, fields, masses, strains, slopes, spin = [], [], [], [], [], []
    # four fibres have the section's area and second moments
    ry, rz = np.sqrt(s.iz / s.area), np.sqrt(s.iy / s.area)
    fibres = [(sy * ry, sz * rz) for sy in (-1, 1) for sz in (-1, 1)]
    if not effects.rotary_inertia:
        fibres = [(0.0, 0.0)]
    for g, weight in zip(GAUSS, WEIGHT, strict=True):
        xi, w = 0.5 * (1 + g), 0.5 * weight * length
        wy, slope_y, turn_z, curve_z = shape(xi, length, phi_z)
        wz, slope_z, turn_y, curve_y = shape(xi, length, phi_y)
        centre, rotation = np.zeros((3, 12)), np.zeros((3, 12))
        centre[0, [0, 6]] = rotation[0, [3, 9]] = 1 - xi, xi
        centre[1, Y_PLANE], rotation[2, Y_PLANE] = wy, turn_z
        centre[2, Z_PLANE], rotation[1, Z_PLANE] = wz * Z_SIGN, -turn_y * Z_SIGN
        for y, z in fibres:
            arm = np.array([0.0, y, z])
            points.append([start + xi * length, y, z])
            fields.append(centre - cross_matrix(arm) @ rotation)
            masses.append(beam.density * s.area * w / len(fibres))
        if not effects.rotary_inertia and effects.torsion:
            spin.append((beam.density * (s.iy + s.iz) * w, rotation[0]))
        if not flexible:
            continue
        bend_z, bend_y = np.zeros(12), np.zeros(12)
        bend_z[Y_PLANE], bend_y[Z_PLANE] = curve_z, curve_y * Z_SIGN
        strains += [(e_modulus * s.iz * w, bend_z), (e_modulus * s.iy * w, bend_y)]
        sy, sz = np.zeros(12), np.zeros(12)
        sy[Y_PLANE], sz[Z_PLANE] = slope_y, slope_z * Z_SIGN
        slopes += [(w / length, sy), (w / length, sz)]
        if effects.shear:
            strains.append((g_modulus * s.shear_area_y * w, sy - rotation[2]))
            strains.append((g_modulus * s.shear_area_z * w, sz + rotation[1]))
    built = Element(np.array(points), np.array(fields), np.array(masses), spin=spin)
    stiffening = effects.centrifugal and effects.axial
    turning = stiffening and turns
    if turning and effects.rotary_inertia:
        half = 0.5 * beam.density * length
        built.sections = [(0, half * s.iz, half * s.iy), (1, half * s.iz, half * s.iy)]
    if flexible:
        twist, stretch = np.zeros(12), np.zeros(12)
        twist[[3, 9]] = stretch[[0, 6]] = -1 / length, 1 / length
        built.strains = [*strains, (g_modulus * s.j * length, twist)]
        helix = [((s.iy + s.iz) / s.area, twist)]
        built.axial = (e_modulus * s.area * length, stretch, slopes + helix if stiffening else [])
        if turning:
            share_z, share_y = phi_z / (1 + phi_z), phi_y / (1 + phi_y)
            kz, ky = e_modulus * s.iz / length, e_modulus * s.iy / length
            stiffness = [kz, 12 * (1 - share_z) * kz, ky, 12 * (1 - share_y) * ky, g_modulus * s.j / length]
            built.strains = []
            built.turning = np.array(stiffness), length, (share_z, share_y)
        if stiffening:
            built.shift = np.diag([0, 0, 0, 0, -1, -1, 0, 0, 0, 0, 1, 1]) * length / 24
    return built


def build_body(body, end: float, axes: np.ndarray, turning: bool) -> Element:
    """A rigid body as six points with its mass, centre and inertia."""
    inertia = np.zeros((3, 3)) if body.inertia is None else np.array(body.inertia)
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    moments, directions = np.linalg.eigh(second)
    points, fields, arms = [], [], []
    for k in range(3):
        for sign in (-1, 1):
            arm = sign * np.sqrt(3 * max(moments[k], 0) / body.mass) * directions[:, k]
            arm = axes.T @ (np.array(body.center_of_mass) + arm)
            row = np.zeros((3, 12))
            row[:, 6:9], row[:, 9:12] = np.eye(3), -cross_matrix(arm)
            points.append(arm + np.array([end, 0.0, 0.0]))
            fields.append(row)
            arms.append(arm)
    arm = np.array(arms) if turning else None
    return Element(np.array(points), np.array(fields), np.full(6, body.mass / 6), arm=arm)


def flexible_link(link: Link) -> bool:
    return bool(link.beam is not None and link.flexible)


class IndependentChain:
    """Mass matrix, forces and accelerations of a scene's chain.

    planar leaves out what lies outside the plane; zeroed lists (link, node, direction (6,) in beam axes),
    none for `root`.
    """

    def __init__(self, scene: Scene, planar: bool = False, zeroed: list | None = None) -> None:
        self.scene = scene
        self.damping = (scene.damping.alpha, scene.damping.beta) if scene.effects.damping else (0, 0)
        self.gravity = np.array(scene.gravity if scene.effects.gravity else (0.0, 0.0, 0.0))
        self.joints = len(scene.joints)
        held = {} if zeroed is None else {(n, i): np.asarray(d) for n, i, d in zeroed}
        effects = scene.effects
        elastic = effects.joint_elasticity and effects.rotor_inertia
        self.turning = effects.centrifugal and effects.axial
        n, self.motor = self.joints, []
        for joint in scene.joints:
            behind = elastic and joint.stiffness is not None
            self.motor.append(n if behind else None)
            n += behind
        self.links = []
        for number, link in enumerate(scene.links):
            along, axes = beam_axes(link)
            length = float(np.linalg.norm(along))
            flexible = bool(link.beam is not None and link.flexible)
            count = link.beam.elements if flexible else (1 if length > 0 else 0)
            own = None
            if (
                zeroed is not None
                and link.joint.type == "revolute"
                and not any(at == number and i == 0 for at, i, _ in zeroed)
            ):
                own, n = n, n + 1
            e = scene.effects
            free = [e.axial, e.bending_z, e.bending_y, e.torsion, e.bending_y, e.bending_z]
            free = [flexible and on for on in free]
            if planar:
                free = [on and k in (0, 1, 5) for k, on in enumerate(free)]
            nodes = []
            for i in range(1, count + 1):
                place = {}
                lost = held.get((number, i))
                pivot = None if lost is None else int(np.argmax(np.abs(lost)))
                for k in range(6):
                    if free[k] and k != pivot:
                        place[k], n = n, n + 1
                nodes.append((place, free, pivot, lost))
            step = length / count if count else 0.0
            elements = [
                build_element(scene, link, i * step, step, flexible)
                for i in range(count if link.beam is not None else 0)
            ]
            both = (link.rigid, link.payload)
            bodies = [build_body(b, length, axes, self.turning) for b in both if b and b.mass > 0]
            self.links.append((link, along, axes, step, own, nodes, elements, bodies))
        self.unknowns = n

    def motion(self, z: np.ndarray, zd: np.ndarray) -> list:
        """For each link: origin, rotation of the beam axes, nodal rows (each Moving)."""
        # each link's end: origin and rotation, displacement and rotation vector in the base frame
        zero = Moving(np.zeros(3))
        ends = {-1: (zero, Moving(np.eye(3)), (zero, zero))}
        k, out = 0, []
        for n, (link, along, axes, step, own, nodes, _, _) in enumerate(self.links):
            origin, turn, end = ends[self.scene.parents[n]]
            q = qd = 0.0
            if link.joint.type != "fixed":
                q, qd, k = z[k], zd[k], k + 1
            revolute, slides = link.joint.type == "revolute", link.joint.type == "prismatic"
            joint_axis = turn @ Moving([0.0, 0.0, 1.0])
            slide = Moving([0.0, 0.0, q if slides else 0.0], [0, 0, qd if slides else 0.0])
            slide = turn @ slide
            angle = link.dh.theta + (q if revolute else 0.0)
            spun = turn @ rotation_z(angle, qd if revolute else 0.0)
            turn = spun @ Moving(rotation_x(link.dh.alpha))
            origin = origin + slide
            basis = turn @ Moving(axes)
            u, r = end
            across = Moving(cross_matrix(r.value), cross_matrix(r.rate))
            carried = across @ slide
            u = u + carried
            if self.turning:
                again = across @ carried
                u = u + Moving(0.5 * again.value, 0.5 * again.rate)
            if own is not None:
                psi = Moving(joint_axis.value * z[own], joint_axis.rate * z[own] + joint_axis.value * zd[own])
                both = across @ psi
                r = r + psi
                if self.turning:
                    r = r + Moving(0.5 * both.value, 0.5 * both.rate)
            u, r = basis.T @ u, basis.T @ r
            if self.turning:
                back = squared(vector_from_slopes, r)
                r = r + Moving(-back.value, -back.rate)
            rows = [Moving(np.concatenate([u.value, r.value]), np.concatenate([u.rate, r.rate]))]
            for place, free, pivot, lost in nodes:
                before = rows[-1]
                value, rate = np.zeros(6, dtype=complex), np.zeros(6, dtype=complex)
                for part, source, full in ((value, z, before.value), (rate, zd, before.rate)):
                    for i in range(6):
                        if i in place:
                            part[i] = source[place[i]]
                        elif not free[i]:
                            # rigid where it may not deform
                            part[i] = full[i]
                            part[i] += step * full[5] if i == 1 else 0.0
                            part[i] -= step * full[4] if i == 2 else 0.0
                    if pivot is not None:
                        part[pivot] = 0.0
                        part[pivot] = -(lost @ part) / lost[pivot]
                if self.turning and not any(free) and not flexible_link(link):
                    value[0] -= 0.5 * step * (before.value[4] ** 2 + before.value[5] ** 2)
                    rate[0] -= step * (before.value[4] * before.rate[4] + before.value[5] * before.rate[5])
                rows.append(Moving(value, rate))
            out.append((origin, basis, rows))
            u = Moving(rows[-1].value[:3], rows[-1].rate[:3])
            r = Moving(rows[-1].value[3:], rows[-1].rate[3:])
            if self.turning:
                r = r + squared(vector_from_slopes, r)
            ends[n] = origin + turn @ Moving(along), turn, (basis @ u, basis @ r)
        return out

    def pieces(self, motion: list):
        """(element or body, origin, basis, rows (12,) Moving) one after the other."""
        for (_, _, _, _, _, _, elements, bodies), (origin, basis, rows) in zip(
            self.links, motion, strict=True
        ):
            for i, element in enumerate(elements):
                a, b = rows[i], rows[i + 1]
                yield (
                    element,
                    origin,
                    basis,
                    Moving(np.concatenate([a.value, b.value]), np.concatenate([a.rate, b.rate])),
                )
            for body in bodies:
                a = rows[-1]
                yield (
                    body,
                    origin,
                    basis,
                    Moving(np.concatenate([a.value, a.value]), np.concatenate([a.rate, a.rate])),
                )

    def velocities(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """Every velocity, times the root of its inertia: (points * 3 and spins and rotors,)."""
        out = []
        for part, origin, basis, d in self.pieces(self.motion(z, zd)):
            moved = part.displacement(d)
            v = origin.rate + (part.points + moved.value) @ basis.rate.T + moved.rate @ basis.value.T
            out.append((np.sqrt(part.mass)[:, None] * v).ravel())
            omega_x = (basis.value.T @ basis.rate)[2, 1]
            out += [[np.sqrt(j) * (omega_x + twist @ d.rate)] for j, twist in part.spin]
        if self.scene.effects.rotor_inertia:
            out.append(np.sqrt(self.rotor) * self.motor_rate(zd))
        return np.concatenate(out)

    def softening_force(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """(n,) what omega x (omega x displacement) does on the elastic displacements within the links."""
        force = np.zeros(self.unknowns)
        virtual = [list(self.pieces(self.motion(z, e))) for e in np.eye(self.unknowns)]
        for n, (part, _, basis, d) in enumerate(self.pieces(self.motion(z, zd))):
            omega = (basis.value.T @ basis.rate).real
            pull = part.field @ d.value.real @ (omega @ omega).T
            for k in range(self.unknowns):
                force[k] += part.mass @ np.sum((part.field @ virtual[k][n][3].rate.real) * pull, axis=1)
        return force

    def coriolis_force(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """(n,) what 2 omega x (elastic rate) does on every coordinate."""
        force = np.zeros(self.unknowns)
        virtual = [list(self.pieces(self.motion(z, e))) for e in np.eye(self.unknowns)]
        for n, (part, _, basis, d) in enumerate(self.pieces(self.motion(z, zd))):
            omega = (basis.value.T @ basis.rate).real
            moved = part.displacement(d)
            rate, c = moved.rate.real, moved.value.real
            twice = 2.0 * rate @ omega.T
            for k in range(self.unknowns):
                _, origin_k, basis_k, d_k = virtual[k][n]
                turn = basis.value.T @ basis_k.rate
                v = (
                    basis.value.T @ origin_k.rate
                    + (part.points + c) @ turn.T
                    + part.displacement(Moving(d.value, d_k.rate)).rate
                )
                force[k] += part.mass @ np.sum(v.real * twice, axis=1)
                for end, *moments in part.sections:
                    at = slice(6 * end + 3, 6 * end + 6)
                    moved = squared(axes_turned, Moving(d.value[at], d.rate[at])).rate.real
                    for axis, moment in enumerate(moments, 1):
                        force[k] += moment * (turn[:, axis].real @ (2.0 * omega @ moved[:, axis]))
                for j, twist in part.spin:
                    # (virtual rotation) . (omega x e_x)
                    across = turn[0, 2] * omega[1, 0] + turn[1, 0] * omega[2, 0]
                    force[k] += j * (twist @ d.rate.real) * across.real
        return force

    @property
    def rotor(self) -> np.ndarray:
        return np.array([j.rotor_inertia * j.gear_ratio**2 for j in self.scene.joints])

    def joint_rate(self, zd: np.ndarray) -> np.ndarray:
        """(m,) rates of the links' sides of the joints (or angles, of coordinates)."""
        rate = np.array(zd[: self.joints])
        k = 0
        for link, _, _, _, own, *_ in self.links:
            if link.joint.type != "fixed":
                rate[k] += zd[own] if own is not None else 0.0
                k += 1
        return rate

    def motor_rate(self, zd: np.ndarray) -> np.ndarray:
        """(m,) rates of the motors (or angles, of coordinates)."""
        rate = self.joint_rate(zd)
        for k, at in enumerate(self.motor):
            if at is not None:
                rate[k] = zd[at]
        return rate

    @property
    def spring(self) -> np.ndarray:
        """(m, 2) stiffness and damping between motor and link."""
        return np.array(
            [
                (0.0, 0.0) if at is None else (joint.stiffness, joint.damping)
                for at, joint in zip(self.motor, self.scene.joints, strict=True)
            ]
        )

    def strain(self, z: np.ndarray, zd: np.ndarray) -> Moving:
        """Every strain with its rate, times the root of its stiffness."""
        values, rates = [], []
        for part, _, _, d in self.pieces(self.motion(z, zd)):
            for k, row in part.strains:
                values.append(np.sqrt(k) * (row @ d.value))
                rates.append(np.sqrt(k) * (row @ d.rate))
            if part.turning is not None:
                turned = part.turning_strains(d)
                values += list(turned.value)
                rates += list(turned.rate)
            if part.axial is not None:
                k, row, slopes = part.axial
                value, rate = row @ d.value, row @ d.rate
                for w, slope in slopes:
                    value = value + 0.5 * w * (slope @ d.value) ** 2
                    rate = rate + w * (slope @ d.value) * (slope @ d.rate)
                values.append(np.sqrt(k) * value)
                rates.append(np.sqrt(k) * rate)
        return Moving(np.array(values), np.array(rates))

    def turned_sections(self, z: np.ndarray, zd: np.ndarray):
        """(second moment, rate of the undeformed axis, rate of its turn's second order), base frame."""
        for part, _, basis, d in self.pieces(self.motion(z, zd)):
            for end, *moments in part.sections:
                at = slice(6 * end + 3, 6 * end + 6)
                turned = squared(axes_turned, Moving(d.value[at], d.rate[at]))
                moved = basis @ turned
                for k, j in enumerate(moments, 1):
                    yield j, basis.rate[:, k], moved.rate[:, k]

    def section_rates(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """(2, 3 sections) both of these rates, times the roots of the moments."""
        found = [(np.sqrt(j) * a, np.sqrt(j) * p) for j, a, p in self.turned_sections(z, zd)]
        return np.array(found).transpose(1, 0, 2).reshape(2, -1) if found else np.zeros((2, 0))

    def kinetic(self, z: np.ndarray, zd: np.ndarray) -> complex:
        v = self.velocities(z, zd)
        axes, turned = self.section_rates(z, zd)
        return 0.5 * v @ v + axes @ turned

    def potential(self, z: np.ndarray) -> complex:
        """Strain energy and gravity."""
        still = np.zeros(self.unknowns)
        strain = self.strain(z, still).value
        twist = self.motor_rate(z) - self.joint_rate(z)
        total = 0.5 * strain @ strain + 0.5 * self.spring[:, 0] @ twist**2
        for part, origin, basis, d in self.pieces(self.motion(z, still)):
            p = origin.value + (part.points + part.displacement(d).value) @ basis.value.T
            total = total - part.mass @ (p @ self.gravity)
        return total

    def elastic_rates(self, zd: np.ndarray) -> np.ndarray:
        """Rates of the same deformation without the joints' turning: q' + phi' taken out."""
        y = zd.copy()
        y[: self.joints + sum(k is not None for k in self.motor)] = 0.0
        k = 0
        for link, *_, own, _, _, _ in self.links:
            if link.joint.type != "fixed":
                y[k], k = (-zd[own] if own is not None else 0.0), k + 1
        return y

    def damping_force(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """alpha M on the elastic velocity of the undeformed robot, beta K on the strains' rates, each by its
        own virtual work."""
        alpha, beta = self.damping
        force = np.zeros(self.unknowns)
        straight = z.copy()
        straight[self.joints + sum(k is not None for k in self.motor) :] = 0.0
        points = self.velocities(straight, self.elastic_rates(zd)).real
        strain_rate = self.strain(z, zd).rate.real
        for k, unit in enumerate(np.eye(self.unknowns)):
            force[k] -= alpha * (self.velocities(straight, self.elastic_rates(unit)).real @ points)
            force[k] -= beta * (self.strain(z, unit).rate.real @ strain_rate)
        return force

    def joint_force(self, zd: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Motor torque and friction on every coordinate."""
        rate = self.motor_rate(zd)
        damper = self.spring[:, 1] * (rate - self.joint_rate(zd))
        effort = np.array(torque, dtype=float)
        if self.scene.effects.joint_friction:
            for k, j in enumerate(self.scene.joints):
                effort[k] -= j.viscous_friction * rate[k]
                if j.coulomb_speed > 0.0:
                    effort[k] -= j.coulomb_friction * np.tanh(rate[k] / j.coulomb_speed)
                else:
                    effort[k] -= j.coulomb_friction * np.sign(rate[k])
        units = np.eye(self.unknowns)
        given = [effort @ self.motor_rate(unit) for unit in units]
        lost = [damper @ (self.motor_rate(unit) - self.joint_rate(unit)) for unit in units]
        return np.array(given) - np.array(lost)

    def acceleration(self, z: np.ndarray, zd: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """(n,) from d/dt dT/dz' - dT/dz + dV/dz = Q, with Lagrange's multipliers where loops close."""
        units = np.eye(self.unknowns)
        columns = np.array([self.velocities(z, e).real for e in units])
        mass = columns @ columns.T
        axes, turned = np.array([self.section_rates(z, e).real for e in units]).transpose(1, 0, 2)
        mass += axes @ turned.T + turned @ axes.T
        ahead = z + 1j * STEP * zd
        along = self.velocities(ahead, zd)
        bias = np.array([(self.velocities(ahead, e) @ along).imag / STEP for e in units])
        axes, turned = self.section_rates(ahead, zd)
        for k, e in enumerate(units):
            unit_axes, unit_turned = self.section_rates(ahead, e)
            bias[k] += (unit_axes @ turned + axes @ unit_turned).imag / STEP
        for k, e in enumerate(units):
            bias[k] -= self.kinetic(z + 1j * STEP * e, zd).imag / STEP
            bias[k] += self.potential(z + 1j * STEP * e).imag / STEP
        effects = self.scene.effects
        if not effects.coriolis:
            bias -= self.coriolis_force(z, zd)
        if not (effects.centrifugal and effects.axial):
            bias -= self.softening_force(z, zd)
        force = self.damping_force(z, zd) + self.joint_force(zd, torque)
        if not self.scene.loops:
            return np.linalg.solve(mass, force - bias)
        gradient = np.array([self.opening(z, e).rate.real for e in units]).T
        convective = self.opening(ahead, zd).rate.imag / STEP
        matrix = np.block([[mass, gradient.T], [gradient, np.zeros((len(gradient),) * 2)]])
        # equations that depend on each other, as in a planar loop in space, leave the accelerations unique
        return np.linalg.lstsq(matrix, np.concatenate([force - bias, -convective]), rcond=1e-14)[0][: len(z)]

    def on_ends(self, z: np.ndarray, zd: np.ndarray):
        """Function of (link's number, vector in its frame, whether a point) that rides on the link's end."""
        motion = self.motion(z, zd)

        def on_end(n: int, vector, point: bool) -> Moving:
            (_, along, axes, *_), (origin, basis, rows) = self.links[n], motion[n]
            inside = axes.T @ np.asarray(vector)
            u, r = rows[-1].value, rows[-1].rate
            value, rate = inside + np.cross(u[3:], inside), np.cross(r[3:], inside)
            if self.turning:
                turned = squared(axes_turned, Moving(u[3:], r[3:]))
                value, rate = value + turned.value @ inside, rate + turned.rate @ inside
            if not point:
                return basis @ Moving(value, rate)
            return origin + basis @ Moving(value + axes.T @ along + u[:3], rate + r[:3])

        return on_end

    def opening(self, z: np.ndarray, zd: np.ndarray) -> Moving:
        """What the closing joints hold at zero, one joint after the other."""
        on_end = self.on_ends(z, zd)
        names = [link.name for link in self.scene.links]

        def rides(link: str, vector, point: bool) -> Moving:
            return Moving(vector) if link == "base" else on_end(names.index(link), vector, point)

        def product(a: Moving, b: Moving) -> tuple:
            return a.value @ b.value, a.rate @ b.value + a.value @ b.rate

        x, y, e = np.eye(3)
        out = []
        for joint in self.scene.loops:
            one, two = joint.links
            a, b = rides(one, joint.point(one), True), rides(two, joint.point(two), True)
            apart = Moving(a.value - b.value, a.rate - b.rate)
            axis = [joint.direction(name) for name in joint.links]
            if joint.joint == "slot":
                _, _, across = np.linalg.svd(axis[1][None])
                out += [product(rides(two, d, False), apart) for d in across[1:]]
                continue
            out += list(zip(apart.value, apart.rate, strict=True))
            if joint.joint == "revolute":
                _, _, across = np.linalg.svd(axis[1][None])
                pairs = [(axis[0], d) for d in across[1:]]
            else:
                pairs = {"universal": [tuple(axis)], "fixed": [(x, y), (y, e), (e, x)]}.get(joint.joint, [])
            out += [product(rides(one, c, False), rides(two, d, False)) for c, d in pairs]
        values, rates = zip(*out, strict=True)
        return Moving(np.array(values), np.array(rates))
