"""Virtual sensors: what instruments on the links would read, without their noise.

    strain_gauge    strain on the beam's surface, along the beam
    imu             angular velocity, specific force (acceleration against free fall), orientation
    pose            position and orientation
    section_force   force and moment that the part beyond puts on the part before

Sensor axes are those of the link's frame, turned with the section; forces and moments stand in beam axes,
turned with the section.  Quaternions are (x, y, z, w) with w not negative.
"""

from __future__ import annotations

import numpy as np

from . import planar_reduced_beam, spatial_reduced_beam
from .acceleration import acceleration
from .attitude import quaternion, turn_matrix, turn_rate
from .beam import AXIAL, BEND_Y, BEND_Z, COLUMNS, LENGTH, SHEAR_Y, SHEAR_Z, START, squared_slope
from .chain import (
    ACCELERATION,
    ALPHA,
    BETA,
    CORIOLIS,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIRST_ELEMENT,
    RATE,
    Workspace,
)
from .dynamics import residual
from .kernel import kernel
from .kinematics import accelerate, place, spatial_row
from .model import Model
from .observation import Observation
from .reduced_chain import CENTRELINE, MODES, PIECES, TENSIONS, buffer_places
from .reduced_link import elongation, recover
from .scene import SceneError
from .schema import Sensor
from .station import inertia_between, interpolate, point_acceleration, section_forces

STRAIN_GAUGE, IMU, POSE, SECTION_FORCE = range(4)
TYPES = {"strain_gauge": STRAIN_GAUGE, "imu": IMU, "pose": POSE, "section_force": SECTION_FORCE}
SIZES = (1, 10, 7, 6)
LETTERS = (
    ("strain",),
    (*(f"angular_velocity_{k}" for k in "xyz"), *(f"specific_force_{k}" for k in "xyz"),
     *(f"orientation_{k}" for k in "xyzw")),
    (*(f"position_{k}" for k in "xyz"), *(f"orientation_{k}" for k in "xyzw")),
    ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"),
)  # fmt: skip
# columns of the integer and of the real table
KIND, LINK, NODE, ELEMENT, OUT, STRAINED = range(6)
XI, PLACE, Y, Z = range(4)


class Sensors:
    """The sensors of a scene, and what they read at the last `look`.

    Attributes
    ----------
    names : of the sensors, in the scene's order; kinds : their types
    values : sensor name to its reading, (1,) strain; (10,) rad/s, m/s2, quaternion; (7,) m, quaternion;
        (6,) N, N m.  Views of one buffer that the next look overwrites
    """

    def __init__(self, model: Model) -> None:
        scene = model.scene
        self.model = model
        self.names = tuple(sensor.name for sensor in scene.sensors)
        self.kinds = {sensor.name: sensor.type for sensor in scene.sensors}
        count = len(scene.sensors)
        self._integers = np.zeros((count, 12), dtype=np.int64)
        self._reals = np.zeros((count, 4))
        sizes = [SIZES[TYPES[sensor.type]] for sensor in scene.sensors]
        ends = np.cumsum([0, *sizes])
        self.buffer = np.zeros(ends[-1])
        self.values = {
            name: self.buffer[a:b] for name, a, b in zip(self.names, ends[:-1], ends[1:], strict=True)
        }
        for row, (sensor, out) in enumerate(zip(scene.sensors, ends[:-1], strict=True)):
            self._set_up(row, sensor, int(out))
        # stress resultants that strains don't tell (rigid links, effects that are off) are those of what is
        # beyond, which takes the forces of the whole robot
        resultants = self._integers[:, KIND] == SECTION_FORCE
        self._whole = bool(np.any(self._integers[resultants, STRAINED:] == 0))
        if self._whole and scene.loops:
            raise SceneError(
                f"{scene.name}: sensors: a section_force on a rigid link, or of an effect that is off, is"
                " what all beyond the section needs, which loops leave open; make link and effects flexible"
            )
        self._integrals, self._scratch, self._rows = np.zeros(9), np.zeros((30, 6)), np.zeros(model.unknowns)
        self._still = np.zeros(model.joints)

    def _set_up(self, row: int, sensor: Sensor, out: int) -> None:
        """Fill the tables' rows of one sensor."""
        model, scene = self.model, self.model.scene
        names = [link.name for link in scene.links]
        n = names.index(sensor.link) if sensor.link else len(names) - 1
        link = scene.links[n]
        at = sensor.place(link)
        first, count, start = (int(k) for k in model.chain.link[n, [FIRST, COUNT, FIRST_ELEMENT]])
        if model.chain.reduced[n, MODES] >= 0:
            assert link.beam is not None
            first, count, start = 0, link.beam.elements, 0  # numbers within the link
        element, node, xi = -1, first, 0.0
        if count:
            step = link.length / count
            k = min(int(at / step * (1.0 - 1e-12)), count - 1)
            element, node, xi = start + k, first + k + 1, at / step - k
        effects = scene.effects
        flexible = link.beam is not None and link.flexible
        strained = [
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
        self._integers[row, :STRAINED] = TYPES[sensor.type], n, node, element, out
        self._integers[row, STRAINED : STRAINED + 6] = strained
        y, z = sensor.point_on(link) if sensor.type == "strain_gauge" else (0.0, 0.0)
        self._reals[row] = xi, at, y, z

    def letters(self, name: str) -> tuple[str, ...]:
        """What the numbers of a sensor are called."""
        return LETTERS[TYPES[self.kinds[name]]]

    def look(self, view: Observation, work: Workspace, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Read the sensors at unknowns x (n,), rates v and accelerations a; `view` has looked at x."""
        if not self.names:
            return
        sense(
            self.model.chain,
            work,
            self._integers,
            self._reals,
            self.model.axes,
            view.pose,
            x,
            v,
            a,
            self._whole,
            self._still,
            self._rows,
            self._scratch,
            self._integrals,
            self.buffer,
        )

    def look_exactly(
        self,
        view: Observation,
        work: Workspace,
        x: np.ndarray,
        v: np.ndarray,
        torque: np.ndarray,
        a: np.ndarray,
    ) -> None:
        """Read the sensors with the accelerations of the equations, written into a (n,).

        Held joints take theirs from a.
        """
        if self.names:
            acceleration(self.model.chain, work, x, v, torque, a)
            self.look(view, work, x, v, a)


@kernel
def orientation(axes, pose, turn, t, out):
    """Quaternion of the sensor's axes: the link's frame, turned by `turn` (3, 3) in beam axes; t (6, 3)."""
    a, b = t[0:3], t[3:6]
    for i in range(3):
        for k in range(3):
            a[i, k] = 0.0
            for m in range(3):
                a[i, k] += pose[3 + 3 * i + m] * turn[m, k]
    for i in range(3):
        for k in range(3):
            b[i, k] = 0.0
            for m in range(3):
                b[i, k] += a[i, m] * axes[k, m]
    quaternion(b, out)


@kernel
def in_section_axes(turn, vector, out):
    """Turn a vector (3,) from the link's beam axes into those of the turned section."""
    for k in range(3):
        out[k] = turn[0, k] * vector[0] + turn[1, k] * vector[1] + turn[2, k] * vector[2]


@kernel
def in_link_axes(axes, vector, out):
    """Components of a vector (3,) given in beam axes in the link's axes (or in both, turned alike)."""
    for k in range(3):
        out[k] = axes[k, 0] * vector[0] + axes[k, 1] * vector[1] + axes[k, 2] * vector[2]


@kernel
def beam_element(reduction, chain, n, m, e):
    """Write the row of element m (of a reduced link, by its number within link n) into e (13,)."""
    if len(reduction) == 0:
        for k in range(COLUMNS):
            e[k] = chain.element[m, k]
        return
    whole, at = chain.reduced[n, MODES] >= 0, chain.reduced[n, PIECES] + COLUMNS * m
    for k in range(COLUMNS):
        e[k] = chain.modal[at + k] if whole else chain.element[m, k]


@kernel
def node_row(reduction, chain, work, n, i, kind, out):
    """Write node i (of a reduced link, by its number in it), displacement or rate, into out (6,)."""
    planar = len(chain.dofs) == 3
    if len(reduction) == 0 or chain.reduced[n, MODES] < 0:
        spatial_row(work.node[kind, i], planar, out)
    else:
        recover(chain, work, n, i, kind, work.row[1])
        spatial_row(work.row[1], planar, out)


@kernel
def stretch(reduction, dofs, chain, work, n, m, rows, rates):
    """Give piece m of the reduced link n the elongation of the link's tension.

    The squared slope shortens the pieces differently; the axial dofs that would follow are not among the
    modes.
    """
    if len(reduction) == 0:
        return
    size, first, b = chain.reduced[n], chain.link[n, FIRST], len(dofs)
    if size[TENSIONS] == 0:
        return
    d, v, own, piece = work.node[DISPLACEMENT], work.node[RATE], work.modal, work.row[2]
    beam_element(reduction, chain, n, m, piece)
    e, at, count = chain.element[chain.link[n, FIRST_ELEMENT]], buffer_places(size, b)[3], size[CENTRELINE]
    if len(dofs) == 3:
        planar_reduced_beam.centreline(e, size, d, first, 1.0, own[at : at + 3 * count])
        planar_reduced_beam.centreline(e, size, v, first, 0.0, own[at + 3 * count : at + 6 * count])
    else:
        t = work.scratch
        spatial_reduced_beam.centreline(e, size, d, first, 1.0, t, own[at : at + 3 * count])
        spatial_reduced_beam.centreline(e, size, v, first, 0.0, t, own[at + 3 * count : at + 6 * count])
    length, pieces = piece[LENGTH], e[LENGTH] / piece[LENGTH]
    long, rate = elongation(size, chain.modal, own, d, v, first, b, m, pieces)
    p, r, pv, rv = rows[0], rows[1], rates[0], rates[1]
    y, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, piece[SHEAR_Z])
    z, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, piece[SHEAR_Y])
    r[0] = p[0] + long - 0.5 * length * (y + z)
    rate -= length * (a0 * pv[1] + a1 * pv[5] + a2 * rv[1] + a3 * rv[5])
    rate -= length * (b0 * pv[2] - b1 * pv[4] + b2 * rv[2] - b3 * rv[4])
    rv[0] = pv[0] + rate


@kernel
def force_beyond(chain, work, n, rows, rates, accelerations, m, xi, c, t, load, out):
    """Stress resultants (6,) at a station of link n from the wrench of all that lies beyond it, link axes.

    The residual has left the sums of inertia forces in work.wrench; m is the station's element, or -1; c (3,)
    the station; t is scratch (10, 6), load (9,).
    """
    planar = len(chain.dofs) == 3
    spatial_row(work.wrench[n], planar, out)
    # without what lies before the station
    whole = chain.reduced[n, MODES] >= 0
    first, node = (0, 1) if whole else (chain.link[n, FIRST_ELEMENT], chain.link[n, FIRST] + 1)
    alpha, coriolis = chain.setting[ALPHA], chain.setting[CORIOLIS] > 0.0
    if m >= 0:
        for k in range(first, m + 1):
            i = node + k - first
            for p in range(2):
                node_row(chain.reduction, chain, work, n, i - 1 + p, DISPLACEMENT, rows[p])
                node_row(chain.reduction, chain, work, n, i - 1 + p, RATE, rates[p])
                node_row(chain.reduction, chain, work, n, i - 1 + p, ACCELERATION, accelerations[p])
            e, part, end = work.row[3], xi if k == m else 1.0, t[6]
            beam_element(chain.reduction, chain, n, k, e)
            load[:] = 0.0
            inertia_between(
                e, work.frame[n], rows, rates, accelerations, alpha, coriolis, True, part, t, load
            )
            interpolate(e, rows, part, end)  # inertia_between sums arms up to there
            e0 = e[START] + part * e[LENGTH] + end[0]
            out[3] -= load[6] + end[1] * load[2] - end[2] * load[1]
            out[4] -= load[7] + end[2] * load[0] - e0 * load[2] + load[5]
            out[5] -= load[8] + e0 * load[1] - end[1] * load[0] - load[4]
            for p in range(3):
                out[p] -= load[p]
    out[3] -= c[1] * out[2] - c[2] * out[1]
    out[4] -= c[2] * out[0] - c[0] * out[2]
    out[5] -= c[0] * out[1] - c[1] * out[0]
    for p in range(6):
        out[p] = -out[p]


@kernel
def sense(chain, work, integers, reals, axes, pose, x, v, a, whole, torque, rhs, t, load, values):
    """Read every sensor into values; `whole`: the forces of the whole robot are needed.

    torque (m,), rhs (n,), t (30, 6) and load (9,) are scratch.
    """
    planar = len(chain.dofs) == 3
    if whole:
        residual(chain, work, x, v, a, torque, rhs)
    else:
        place(chain, work, x)
        accelerate(chain, work, v, a)
    node = work.node
    rows, rates, accelerations = t[10:12], t[12:14], t[14:16]
    d, dv, da = t[16], t[17], t[18]
    c, f, w = t[19], t[20], t[21]
    resultant, beyond = t[22:25], t[25]
    turn = work.scratch[0:3]
    for s in range(integers.shape[0]):
        kind, n, i, m = integers[s, KIND], integers[s, LINK], integers[s, NODE], integers[s, ELEMENT]
        xi, at = reals[s, XI], reals[s, PLACE]
        out = values[integers[s, OUT] :]
        frame, e = work.frame[n], work.row[4]
        if m >= 0:
            beam_element(chain.reduction, chain, n, m, e)
            for k in range(2):
                node_row(chain.reduction, chain, work, n, i - 1 + k, DISPLACEMENT, rows[k])
                node_row(chain.reduction, chain, work, n, i - 1 + k, RATE, rates[k])
                node_row(chain.reduction, chain, work, n, i - 1 + k, ACCELERATION, accelerations[k])
            stretch(chain.reduction, chain.dofs, chain, work, n, m, rows, rates)
            interpolate(e, rows, xi, d)
            interpolate(e, rates, xi, dv)
            interpolate(e, accelerations, xi, da)
        else:
            spatial_row(node[DISPLACEMENT, i], planar, d)
            spatial_row(node[RATE, i], planar, dv)
            spatial_row(node[ACCELERATION, i], planar, da)
        c[0], c[1], c[2] = at + d[0], d[1], d[2]
        if kind == IMU:
            turn_matrix(d[3:6], turn)
            in_section_axes(turn, frame[0:3], f)
            turn_rate(d[3:6], dv[3:6], w)
            for k in range(3):
                w[k] += f[k]
            in_link_axes(axes[n], w, out[0:3])
            point_acceleration(frame, c, dv, da, w)
            in_section_axes(turn, w, f)
            in_link_axes(axes[n], f, out[3:6])
            orientation(axes[n], pose[n], turn, work.scratch[3:9], out[6:10])
        elif kind == POSE:
            turn_matrix(d[3:6], turn)
            for k in range(3):
                out[k] = pose[n, k]
                for p in range(3):
                    out[k] += pose[n, 3 + 3 * k + p] * c[p]
            orientation(axes[n], pose[n], turn, work.scratch[3:9], out[3:7])
        else:
            beta = chain.setting[BETA]
            if m >= 0:
                section_forces(
                    e, frame, rows, rates, accelerations, chain.setting, xi, t, load, work.scratch, resultant
                )
            if kind == STRAIN_GAUGE:
                out[0] = strain(e, integers[s, STRAINED:], reals[s, Y], reals[s, Z], resultant)
                continue
            if whole:
                force_beyond(chain, work, n, rows, rates, accelerations, m, xi, c, t, load, beyond)
                turn_matrix(d[3:6], turn)
                in_section_axes(turn, beyond[0:3], f)
                in_section_axes(turn, beyond[3:6], w)
                for k in range(3):
                    beyond[k], beyond[3 + k] = f[k], w[k]
            for k in range(6):
                if integers[s, STRAINED + k] == 1:
                    out[k] = resultant[0, k] + beta * resultant[1, k] + resultant[2, k]
                else:
                    out[k] = beyond[k]


@kernel
def strain(e, strained, y, z, resultant):
    """Axial strain of the fibre at (y, z) of a section with stress resultants (3, 6)."""
    length = e[LENGTH]
    axial, bend_y, bend_z = e[AXIAL] * length, e[BEND_Y] * length, e[BEND_Z] * length
    found = 0.0
    if strained[0] == 1:
        found += (resultant[0, 0] + resultant[2, 0]) / axial
    if strained[4] == 1:
        found += z * (resultant[0, 4] + resultant[2, 4]) / bend_y
    if strained[5] == 1:
        found -= y * (resultant[0, 5] + resultant[2, 5]) / bend_z
    return found
