"""The sensors' readings, in either formulation: a station's section, its motion and its stress resultants.

A station has a frame, the link's or with co-moving frames its element's carrier, in which the section moves
by the displacements of the two nodes beside it.
"""

from __future__ import annotations

from ..compiled.flat import flat
from ..compiled.kernel import kernel
from ..elements.beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    COLUMNS,
    LENGTH,
    SHEAR_Y,
    SHEAR_Z,
    START,
    STIFFENING,
    squared_helix,
    squared_slope,
)
from ..equations.co_moving import station as co_moving_station
from ..equations.co_moving.view import carrier_pose
from ..equations.dynamics.residual import residual
from ..equations.forces.damping import elastic_rates
from ..equations.kinematics.nodal_motion import accelerate, place, spatial_row
from ..equations.reduced import plane as planar_reduced_beam
from ..equations.reduced import space as spatial_reduced_beam
from ..equations.reduced.link import elongation, recover
from ..model.chain import (
    ACCELERATION,
    ALPHA,
    BETA,
    COORDINATES,
    DISPLACEMENT,
    FIRST,
    FIRST_ELEMENT,
    RATE,
    RELATIVE,
    SPIN,
)
from ..model.reduced.layout import CENTRELINE, LINE, MODES, PIECES, TENSIONS
from ..rotations.attitude import quaternion, section_spin, section_turn
from ..rotations.section_turn import rotation_vector, rotation_vector_rate
from .station import interpolate, point_acceleration, section_forces, slopes, take_part

STRAIN_GAUGE, IMU, POSE, SECTION_FORCE = range(4)
# columns of the sensors' integer and real tables
KIND, LINK, NODE, ELEMENT, OUT, STRAINED = range(6)
XI, PLACE, Y, Z = range(4)


@kernel
def orientation(axes, pose, turn, t, out):
    """Quaternion of the sensor's axes: the link's frame, turned by `turn` (3, 3) in beam axes; t (6, 3).

    Of the two that there are it is the one nearer to the last reading, which is still in out.
    """
    a, b = t[0:3], t[3:6]
    x, y, z, w = out[0], out[1], out[2], out[3]
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
    if x * out[0] + y * out[1] + z * out[2] + w * out[3] < 0.0:
        for k in range(4):
            out[k] = -out[k]


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
    """Write the row of element m (of a reduced link, by its number within link n) into e (15,)."""
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
    e, at, count = chain.element[chain.link[n, FIRST_ELEMENT]], size[LINE], size[CENTRELINE]
    if len(dofs) == 3:
        planar_reduced_beam.centreline(e, size, flat(v), first, 0.0, own, at + 2 * count)
    else:
        spatial_reduced_beam.centreline(e, size, flat(v), first, 0.0, own, at + 3 * count)
    length, pieces = piece[LENGTH], e[LENGTH] / piece[LENGTH]
    long, rate = elongation(size, chain.modal, own, d, v, first, b, m, pieces)
    p, r, pv, rv = rows[0], rows[1], rates[0], rates[1]
    y, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, piece[SHEAR_Z])
    z, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, piece[SHEAR_Y])
    x, c = squared_helix(piece, p[3], r[3])
    r[0] = p[0] + long - 0.5 * length * (x + y + z)
    rate -= length * (a0 * pv[1] + a1 * pv[5] + a2 * rv[1] + a3 * rv[5])
    rate -= length * (b0 * pv[2] - b1 * pv[4] + b2 * rv[2] - b3 * rv[4])
    rv[0] = pv[0] + rate - length * c * (rv[3] - pv[3])


@kernel
def station_rows(co, chain, work, n, i, rows, rates, accelerations):
    """Write the nodal rows (2, 6) at both ends of the element of link n that ends at node i."""
    if len(co) > 0:
        co_moving_station.element_rows(chain.dofs, work, i, DISPLACEMENT, rows)
        co_moving_station.element_rows(chain.dofs, work, i, RATE, rates)
        co_moving_station.element_rows(chain.dofs, work, i, ACCELERATION, accelerations)
    else:
        for k in range(2):
            node_row(chain.reduction, chain, work, n, i - 1 + k, DISPLACEMENT, rows[k])
            node_row(chain.reduction, chain, work, n, i - 1 + k, RATE, rates[k])
            node_row(chain.reduction, chain, work, n, i - 1 + k, ACCELERATION, accelerations[k])


@kernel
def station_frame(co, work, n, i, out):
    """Copy the motion (9,) of a station's frame: link n's, or the carrier's of the element that ends at i."""
    for k in range(9):
        out[k] = work.moving[i, k] if len(co) > 0 else work.frame[n, k]


@kernel
def station_pose(co, chain, work, n, i, link_pose, out):
    """Write that frame's origin and rotation (12,), base axes; link_pose (12,) is that of link n's start."""
    if len(co) > 0:
        carrier_pose(chain, work, n, i, link_pose, out, work.row[1])
    else:
        for k in range(12):
            out[k] = link_pose[k]


@kernel
def station_section(chain, work, integers, reals, s, frame, e, t):
    """Sensor s: motion (9,) of its frame, its element e (15,), nodal rows and what follows from them into t.

    t (30, 6): rows 10 to 15 of the nodes (displacement, rate, acceleration), 16 to 18 of the section, 19 its
    place.
    """
    n, i, m = integers[s, LINK], integers[s, NODE], integers[s, ELEMENT]
    xi = reals[s, XI]
    planar = len(chain.dofs) == 3
    rows, rates, accelerations = t[10:12], t[12:14], t[14:16]
    d, dv, da, c = t[16], t[17], t[18], t[19]
    station_frame(chain.co_moving, work, n, i, frame)
    c[0] = reals[s, PLACE]
    if m >= 0:
        beam_element(chain.reduction, chain, n, m, e)
        station_rows(chain.co_moving, chain, work, n, i, rows, rates, accelerations)
        stretch(chain.reduction, chain.dofs, chain, work, n, m, rows, rates)
        interpolate(e, rows, xi, d)
        interpolate(e, rates, xi, dv)
        interpolate(e, accelerations, xi, da)
        c[0] = e[START] + xi * e[LENGTH]
    else:
        spatial_row(work.node[DISPLACEMENT, i], planar, d)
        spatial_row(work.node[RATE, i], planar, dv)
        spatial_row(work.node[ACCELERATION, i], planar, da)
    c[0], c[1], c[2] = c[0] + d[0], d[1], d[2]
    turn_section(chain.co_moving, chain, d[3:6], dv[3:6])


@kernel
def turn_section(co, chain, turn, rate):
    """Make the rotational entries of a row and of its rate (3,) those of the section's rotation vector."""
    if len(co) == 0 and chain.setting[SPIN] > 0.0:
        rotation_vector_rate(turn, rate, rate)
        rotation_vector(turn, turn)


@kernel
def free_accelerations(co, chain, v, a, out):
    """Write into out (n,) what `accelerate` needs to move the links by a.

    It moves co-moving frames with Rayleigh's alpha times the elastic rates besides.
    """
    alpha, m = chain.setting[ALPHA] if len(co) > 0 else 0.0, int(chain.setting[COORDINATES])
    for i in range(a.size):
        out[i] = a[i] - alpha * v[i] if i >= m else a[i]


@kernel
def force_beyond(co, chain, work, n, i, m, frame, setting, xi, t, load, out):
    """Stress resultants (6,) at a station of link n from the wrench of all that lies beyond it, frame's axes.

    The residual has left the sums of inertia forces; m is the station's element, that ends at node i, or -1.
    """
    rows, rates, accelerations, c = t[10:12], t[12:14], t[14:16], t[19]
    if len(co) > 0:
        e = work.row[4]
        co_moving_station.wrench_beyond(
            chain, work, i, m, e, frame, rows, rates, accelerations, t, work.scratch, out
        )
        if m >= 0:
            take_part(e, frame, rows, rates, accelerations, setting, xi, t, load, out)
    else:
        link_wrench_beyond(chain, work, n, m, frame, rows, rates, accelerations, setting, xi, t, load, out)
    out[3] -= c[1] * out[2] - c[2] * out[1]
    out[4] -= c[2] * out[0] - c[0] * out[2]
    out[5] -= c[0] * out[1] - c[1] * out[0]
    for p in range(6):
        out[p] = -out[p]


@kernel
def link_wrench_beyond(chain, work, n, m, frame, rows, rates, accelerations, setting, xi, t, load, out):
    """Wrench (6,) about link n's origin that all beyond xi of its element m needs; m is -1 for its start."""
    spatial_row(work.wrench[n], len(chain.dofs) == 3, out)
    if m < 0:
        return
    # without what lies before the station
    whole = chain.reduced[n, MODES] >= 0
    first, node = (0, 1) if whole else (chain.link[n, FIRST_ELEMENT], chain.link[n, FIRST] + 1)
    e = work.row[3]
    for k in range(first, m + 1):
        station_rows(chain.co_moving, chain, work, n, node + k - first, rows, rates, accelerations)
        beam_element(chain.reduction, chain, n, k, e)
        part = xi if k == m else 1.0
        take_part(e, frame, rows, rates, accelerations, setting, part, t, load, out)


@kernel
def read_motion(chain, work, integers, reals, axes, pose, t, values):
    """Read the sensors of motion into values."""
    frame, e, at, turn = work.row[5], work.row[4], work.row[3], work.scratch[0:3]
    d, dv, da, c, f, w = t[16], t[17], t[18], t[19], t[20], t[21]
    for s in range(integers.shape[0]):
        kind, n = integers[s, KIND], integers[s, LINK]
        if kind != IMU and kind != POSE:
            continue
        out = values[integers[s, OUT] :]
        station_section(chain, work, integers, reals, s, frame, e, t)
        station_pose(chain.co_moving, chain, work, n, integers[s, NODE], pose[n], at)
        section_turn(d, turn)
        if kind == IMU:
            in_section_axes(turn, frame[0:3], f)
            section_spin(d, dv, w)
            for k in range(3):
                w[k] += f[k]
            in_link_axes(axes[n], w, out[0:3])
            point_acceleration(frame, c, dv, da, w)
            in_section_axes(turn, w, f)
            in_link_axes(axes[n], f, out[3:6])
            orientation(axes[n], at, turn, work.scratch[3:9], out[6:10])
        else:
            for k in range(3):
                out[k] = at[k]
                for p in range(3):
                    out[k] += at[3 + 3 * k + p] * c[p]
            orientation(axes[n], at, turn, work.scratch[3:9], out[3:7])


@kernel
def read_stress(chain, work, integers, reals, setting, whole, t, load, values):
    """Read the sensors of strains and stress resultants into values."""
    frame, e, turn = work.row[5], work.row[4], work.scratch[0:3]
    rows, rates, accelerations = t[10:12], t[12:14], t[14:16]
    d, f, resultant, beyond = t[16], t[20], t[22:25], t[25]
    for s in range(integers.shape[0]):
        kind, n, i, m = integers[s, KIND], integers[s, LINK], integers[s, NODE], integers[s, ELEMENT]
        if kind != STRAIN_GAUGE and kind != SECTION_FORCE:
            continue
        xi, out = reals[s, XI], values[integers[s, OUT] :]
        balanced = whole and (kind == SECTION_FORCE or chain.reduced[n, MODES] >= 0)
        station_section(chain, work, integers, reals, s, frame, e, t)
        if m >= 0 and not (balanced and kind == SECTION_FORCE):
            section_forces(
                e, frame, rows, rates, accelerations, setting, xi, t, load, work.scratch, resultant
            )
        if balanced:
            force_beyond(chain.co_moving, chain, work, n, i, m, frame, setting, xi, t, load, beyond)
            section_turn(d, turn)
            turn_back(turn, beyond, f)
        if kind == STRAIN_GAUGE:
            if balanced:
                for k in range(6):
                    resultant[0, k], resultant[2, k] = beyond[k] - setting[BETA] * resultant[1, k], 0.0
            out[0] = strain(e, integers[s, STRAINED:], reals[s, Y], reals[s, Z], resultant)
            continue
        if not balanced:
            for k in range(6):
                beyond[k] = resultant[0, k] + setting[BETA] * resultant[1, k] + resultant[2, k]
            if e[STIFFENING] > 0.0:
                # the axial force lies along the frame, what is across it has left the shear forces
                y, z = slopes(e, rows, xi)
                beyond[1] += beyond[0] * y
                beyond[2] += beyond[0] * z
            section_turn(d, turn)
            turn_back(turn, beyond, f)
        for k in range(6):
            out[k] = beyond[k]


@kernel
def add_damping(chain, v, a, out):
    """Write accelerations whose inertia loads the links as a (n,) and Rayleigh's alpha at rates v (n,) do."""
    if chain.setting[RELATIVE] == 0.0:
        for i in range(out.size):
            out[i] = a[i]
        return
    elastic_rates(chain, v, out)
    for i in range(out.size):
        out[i] = a[i] + chain.setting[RELATIVE] * out[i]


@kernel
def turn_back(turn, wrench, f):
    """Turn a force and moment (6,) from the frame's axes into those of a turned section, in place; f (3,)."""
    for at in range(0, 6, 3):
        in_section_axes(turn, wrench[at : at + 3], f)
        for k in range(3):
            wrench[at + k] = f[k]


@kernel
def sense(
    chain, work, integers, reals, setting, axes, pose, x, v, a, felt, whole, torque, rhs, t, load, values
):
    """Read every sensor into values, of motion with the accelerations `felt` (n,), of stress with a (n,).

    `whole`: the forces of the whole robot are needed.

    setting is the chain's, but for what co-moving frames hold by themselves; torque (m,), rhs (n,), t (30, 6)
    and load (9,) are scratch.
    """
    place(chain, work, x)
    free_accelerations(chain.co_moving, chain, v, felt, rhs)
    accelerate(chain, work, v, rhs)
    read_motion(chain, work, integers, reals, axes, pose, t, values)
    loaded = work.vector[0]
    add_damping(chain, v, a, loaded)
    if whole:
        residual(chain, work, x, v, loaded, torque, rhs)
    else:
        accelerate(chain, work, v, loaded)
    read_stress(chain, work, integers, reals, setting, whole, t, load, values)


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
