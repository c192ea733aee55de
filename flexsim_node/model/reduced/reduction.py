"""Craig-Bampton reduction of a link: its ends, and the lowest modes of the link with its ends held.

R. R. Craig & M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA J. 6 (1968) 1313.

The static shapes of a uniform beam are those of one element as long as the link.  So a reduced link is that
element, with the modes as further functions of its centreline and of its sections' rotation:

    centreline  c(x) = sum_k f_k(x) c_k       f_0..f_3 Hermite's cubics over the link, then the deflections
    rotation    phi(x) = sum_k r_k(x) phi_k   r_0..r_2 quadratics (start, middle, end), then the rotations

A mode is axial, bends in the beam's x-y or x-z plane, or twists; they are kept in this order.  The inertia
forces need nothing but the functions' constant products, integral f_i f_k dm and integral r_i r_k dx: what
the finite elements of the link give, projected.

With the `centrifugal` effect the axial strain that goes with the squared slope w'^2 / 2 is projected on the
strains that the axial dofs can take up, uniform and those of the axial modes: it can't lock, follows from an
energy, and is the full model's where all modes are kept.  A third of the modes, at most AXIAL_MODES,
are the first axial ones, so that a spinning link's tension may fall off towards its end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from ...elements.beam import (
    AXIAL,
    HERMITE_MASS,
    LENGTH,
    MASS,
    QUADRATIC_MASS,
    SHEAR_Y,
    SHEAR_Z,
    hermite,
    middle_rotation,
    squared_slope,
)
from .layout import (
    BACK_Y,
    BACK_Z,
    COLUMNS,
    COUPLING,
    CROSS_Y,
    CROSS_Z,
    ENDS,
    HELICES,
    LUMP_GRAM,
    MASS_GRAM,
    MODAL_MASS,
    MODAL_STIFFNESS,
    MODES,
    PIECES,
    ROTATION,
    SHAPE,
    SLOPE_Y,
    SLOPE_Z,
    STRAINS,
    TENSION,
    TURN_GRAM,
    eights,
    fours,
    places,
)
from .turning_products import helices, strain_stiffness, turning_products

AXIAL_MODES = 2
# nodal dofs of the kinds of modes, in their order
EXTENSION, BEND_XY, BEND_XZ, TWIST = (0,), (1, 5), (2, 4), (3,)
KINDS = (EXTENSION, BEND_XY, BEND_XZ, TWIST)


@dataclass(frozen=True)
class ReducedLink:
    """One of them, before padding; coordinates (start node, end node, modes) in six dofs a node."""

    counts: tuple[int, int, int, int]  # modes of each kind
    mass: np.ndarray
    section: np.ndarray
    slope: tuple[np.ndarray, np.ndarray]
    tension: np.ndarray
    modal_mass: np.ndarray
    modal_stiffness: np.ndarray
    ends: np.ndarray  # (12, 12) stiffness of (end node, start node)
    coupling: np.ndarray  # (P, 12), likewise
    element: np.ndarray  # (E, 15)
    shape: np.ndarray  # (nodes, 6, 12 + P)
    cross: tuple[np.ndarray, ...]  # products of second order, see turning_products.py
    strain: np.ndarray  # stiffness of the strains that these act on
    helix: np.ndarray  # (tensions, twists, .) likewise of the twists' slopes
    lump: np.ndarray  # products of the rotation's functions at the elements' ends
    frequency: np.ndarray  # (P,) of the link with its ends held, Hz


def fixed_interface_modes(
    mass: np.ndarray, stiffness: np.ndarray, nodes: int
) -> list[tuple[float, int, np.ndarray]]:
    """All modes of a link with its ends held: (squared frequency, kind, shape (nodes, 6)), kind by kind.

    mass, stiffness : (6 nodes, 6 nodes) of the whole link.  A shape's mean square displacement, weighted with
    the mass, is one (a twist's likewise), so that a modal coordinate reads in m or rad.
    """
    found = []
    for kind, dofs in enumerate(KINDS):
        place = np.array([6 * i + k for i in range(1, nodes - 1) for k in dofs], dtype=np.int64)
        m, k = mass[np.ix_(place, place)], stiffness[np.ix_(place, place)]
        if place.size == 0 or not np.all(np.diag(k) > 0.0) or not np.all(np.diag(m) > 0.0):
            continue
        _, vectors = eigh(m, k)  # the lowest modes keep all their digits this way
        whole = np.zeros(6 * nodes)
        whole[dofs[0] :: 6] = 1.0
        weight = whole @ mass @ whole
        for vector in vectors.T[::-1]:
            vector = vector * np.sqrt(weight / (vector @ m @ vector))
            vector = vector * np.sign(vector[np.argmax(np.abs(vector))])
            shape = np.zeros(6 * nodes)
            shape[place] = vector
            found.append((float(vector @ k @ vector / weight), kind, shape.reshape(nodes, 6)))
    return found


def choose_modes(modes: list, kinds: tuple[int, ...], count: int, axial: int) -> list:
    """`count` modes of these kinds, kind by kind: the first `axial` axial ones and the lowest others."""
    rank = sorted((m for m in modes if m[1] in kinds), key=lambda m: m[0])
    first = [m for m in rank if m[1] == 0][:axial]
    others = [m for m in rank if not any(m is k for k in first)]
    kept = first + others[: count - len(first)]
    return [m for m in modes if any(m is k for k in kept)]


def centreline_functions(rows: np.ndarray, shapes: list) -> np.ndarray:
    """(4 + modes, elements, 4): Hermite coefficients, element by element, of every function."""
    length = float(np.sum(rows[:, LENGTH]))
    out = np.zeros((4 + len(shapes), len(rows), 4))
    for e, row in enumerate(rows):
        h = row[LENGTH]
        for side in (0, 1):
            s = (e + side) * h / length
            value = (1 - 3 * s**2 + 2 * s**3, s - 2 * s**2 + s**3, 3 * s**2 - 2 * s**3, s**3 - s**2)
            slope = (6 * s**2 - 6 * s, 1 - 4 * s + 3 * s**2, 6 * s - 6 * s**2, 3 * s**2 - 2 * s)
            out[:4, e, 2 * side] = value
            out[:4, e, 2 * side + 1] = np.array(slope) * h / length
        for i, (_, kind, u) in enumerate(shapes):
            p, r = u[e], u[e + 1]
            if kind == 0:
                out[4 + i, e] = p[0], r[0] - p[0], r[0], r[0] - p[0]
            elif kind == 1:
                out[4 + i, e] = hermite(p[1], p[5], r[1], r[5], h, row[SHEAR_Z])
            elif kind == 2:
                out[4 + i, e] = hermite(p[2], -p[4], r[2], -r[4], h, row[SHEAR_Y])
    return out


def rotation_functions(rows: np.ndarray, shapes: list) -> np.ndarray:
    """(3 + modes, elements, 3): values at start, middle and end of every element, of every function."""
    count = len(rows)
    out = np.zeros((3 + len(shapes), count, 3))
    for e, row in enumerate(rows):
        h = row[LENGTH]
        for at in range(3):
            s = (e + 0.5 * at) / count
            out[:3, e, at] = (1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)
        for i, (_, kind, u) in enumerate(shapes):
            p, r = u[e], u[e + 1]
            if kind == 1:
                middle = middle_rotation(p[1], p[5], r[1], r[5], h, row[SHEAR_Z])
                out[3 + i, e] = p[5], middle, r[5]
            elif kind == 2:
                middle = -middle_rotation(p[2], -p[4], r[2], -r[4], h, row[SHEAR_Y])
                out[3 + i, e] = p[4], middle, r[4]
            elif kind == 3:
                out[3 + i, e] = p[3], 0.5 * (p[3] + r[3]), r[3]
    return out


def padded(functions: np.ndarray, length: int) -> np.ndarray:
    """Functions and zeros up to a length."""
    return np.concatenate([functions, np.zeros((length - len(functions), *functions.shape[1:]))])


def end_shapes(row: np.ndarray, nodes: int) -> np.ndarray:
    """(nodes, 6, 12): nodal displacements of the link as one element (row) for (start node, end node)."""
    length, out = row[LENGTH], np.zeros((nodes, 6, 12))
    for k, unit in enumerate(np.eye(12)):
        p, r = unit[:6], unit[6:]
        y = hermite(p[1], p[5], r[1], r[5], length, row[SHEAR_Z])
        z = hermite(p[2], -p[4], r[2], -r[4], length, row[SHEAR_Y])
        turn_z = middle_rotation(p[1], p[5], r[1], r[5], length, row[SHEAR_Z])
        turn_y = -middle_rotation(p[2], -p[4], r[2], -r[4], length, row[SHEAR_Y])
        for i in range(nodes):
            s = i / (nodes - 1)
            cubic = (1 - 3 * s**2 + 2 * s**3, s - 2 * s**2 + s**3, 3 * s**2 - 2 * s**3, s**3 - s**2)
            square = ((1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1))
            out[i, 0, k] = (1 - s) * p[0] + s * r[0]
            out[i, 1, k], out[i, 2, k] = np.dot(cubic, y), np.dot(cubic, z)
            out[i, 3, k] = (1 - s) * p[3] + s * r[3]
            out[i, 4, k] = np.dot(square, (p[4], turn_y, r[4]))
            out[i, 5, k] = np.dot(square, (p[5], turn_z, r[5]))
    return out


def assemble(matrices: np.ndarray) -> np.ndarray:
    """(6 nodes, 6 nodes) of a link from its elements' (12, 12), nodes ordered (end, start)."""
    count = len(matrices)
    out = np.zeros((6 * (count + 1), 6 * (count + 1)))
    for e, matrix in enumerate(matrices):
        place = np.r_[6 * e + 6 : 6 * e + 12, 6 * e : 6 * e + 6]
        out[np.ix_(place, place)] += matrix
    return out


def reduce_link(
    whole: np.ndarray,
    ends: np.ndarray,
    rows: np.ndarray,
    masses: np.ndarray,
    stiffnesses: np.ndarray,
    count: int,
    free: list[bool],
    planar: bool,
    flat: bool,
    stiffening: bool,
) -> ReducedLink:
    """Reduce a link of E elements to its ends and `count` modes.

    Parameters
    ----------
    whole : row of beam.py for the link as one element; ends : (12, 12) its stiffness, (end, start)
    rows : (E, 15), likewise of each element; masses, stiffnesses : (E, 12, 12), nodes ordered (end, start)
    free : (6,) which nodal dofs move
    planar : the plane's modes only
    flat : the scene stays in the plane, so that the modes beyond it are counted for themselves
    stiffening : the axial force acts on the slope
    """
    nodes = len(rows) + 1
    mass, stiffness = assemble(masses), assemble(stiffnesses)
    modes = [m for m in fixed_interface_modes(mass, stiffness, nodes) if free[KINDS[m[1]][0]]]
    axial = min(AXIAL_MODES, count // 3) if stiffening else 0
    if flat:
        shapes = choose_modes(modes, (0, 1), count, axial)
        if not planar:
            shapes += choose_modes(modes, (2, 3), count, 0)
    else:
        shapes = choose_modes(modes, (0, 1, 2, 3), count, axial)
    counts = tuple(sum(m[1] == kind for m in shapes) for kind in range(4))
    first, last = counts[0], sum(counts[:3])
    y, z = counts[1:3]
    lines, turns = centreline_functions(rows, shapes[:last]), rotation_functions(rows, shapes[first:])
    # ordered as layout.py has them
    own_y, own_z = 4 + first + y, 3 + y
    lines = np.concatenate([lines[4 + first : own_y], lines[:4], lines[own_y:], lines[4 : 4 + first]])
    turns = np.concatenate([turns[3:own_z], turns[:3], turns[own_z:]])
    f = padded(lines, fours(max(len(lines), y + fours(4 + z), fours(4 + y))))
    r = padded(turns, fours(len(turns)))
    shape = np.zeros((nodes, 6, 12 + len(shapes)))
    shape[:, :, :12] = end_shapes(whole, nodes)
    for i, (_, _, u) in enumerate(shapes):
        shape[:, :, 12 + i] = u
    flatly = shape.reshape(6 * nodes, -1)
    own = flatly[:, 12:]
    across = own.T @ mass @ flatly[:, :12]
    # the axial strains that the link can take up: how much each element is stretched
    uniform = np.full(nodes - 1, 1.0 / (nodes - 1))
    stretch = np.array([uniform, *(np.diff(m[2][:, 0]) for m in shapes[:first])])
    spring = rows[:, AXIAL]
    tension = (stretch**2) @ spring
    unit = np.array([squared_slope(*row, 1.0, 0.0)[1:] for row in np.eye(4)])
    tensions = 1 + first if stiffening else 0
    weights = stretch[:tensions] * spring / rows[:, LENGTH] / tension[:tensions, None]
    slopes = [np.zeros(0), np.zeros(0)]
    for k, functions in enumerate((lines[: y + 4], lines[y : y + 4 + z])[: 1 if planar else 2]):
        wide = padded(functions, fours(len(functions)))
        slopes[k] = np.einsum("iea,ab,jeb,te->itj", functions, unit, wide, weights)
    modal_stiffness = np.einsum("ai,ab,bi->i", own, stiffness, own)
    return ReducedLink(
        counts=counts,
        mass=np.einsum("iea,ab,jeb,e->ij", f, HERMITE_MASS, f, rows[:, MASS]),
        section=np.einsum("iea,ab,jeb,e->ij", r, QUADRATIC_MASS, r, rows[:, LENGTH]),
        slope=(slopes[0], slopes[1]),
        tension=tension if stiffening else np.zeros(0),
        modal_mass=np.einsum("ai,ab,bi->i", own, mass, own),
        modal_stiffness=modal_stiffness,
        ends=ends,
        coupling=np.concatenate([across[:, 6:], across[:, :6]], axis=1),
        element=rows,
        shape=shape,
        cross=turning_products(whole, rows, shape, counts, stiffening and not planar),
        strain=strain_stiffness(whole, modal_stiffness, counts),
        helix=helices(rows, shape, counts, weights if stiffening and not planar else weights[:0]),
        lump=np.einsum("iea,a,jea,e->ij", r, (0.5, 0.0, 0.5), r, rows[:, LENGTH]),
        frequency=np.sqrt([m[0] for m in shapes]) / (2.0 * np.pi),
    )


def reduced_links(
    found: dict[int, ReducedLink], links: int, dofs: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Table (L, 48 + 2P) and tape of constants of a chain's reduced links (link number to its reduction)."""
    b = len(dofs)
    both = [*dofs, *(6 + k for k in dofs)]
    most = max((sum(one.counts) for one in found.values()), default=0)
    table = np.zeros((links, COLUMNS + 2 * most), dtype=np.int64)
    table[:, MODES] = -1
    tape: list[tuple[int, np.ndarray]] = []
    constants = buffers = 0
    for n, one in found.items():
        modes = sum(one.counts)
        table[n, : ROTATION + 1] = (
            -(-modes // b),
            modes,
            *one.counts[:3],
            len(one.tension),
            len(one.mass),
            len(one.section),
        )
        shape = one.shape[:, dofs][:, :, [*both, *range(12, 12 + modes)]]
        buffers = places(table[n], b, constants, shape.size, buffers)
        # the kernels go along nodal rows, of which the start's is the first
        ends = np.zeros((2 * b, fours(2 * b)))
        ends[:, : 2 * b] = one.ends[np.ix_([*both[b:], *both[:b]], [*both[b:], *both[:b]])]
        parts = (
            (MASS_GRAM, one.mass), (TURN_GRAM, one.section), (SLOPE_Y, one.slope[0]), (SLOPE_Z, one.slope[1]),
            (TENSION, one.tension), (MODAL_MASS, one.modal_mass), (MODAL_STIFFNESS, one.modal_stiffness),
            (ENDS, ends), (COUPLING, one.coupling[:, both]), (SHAPE, shape), (PIECES, one.element),
            (CROSS_Z, one.cross[0]), (CROSS_Y, one.cross[1]), (BACK_Z, one.cross[2]), (BACK_Y, one.cross[3]),
            (HELICES, one.helix), (LUMP_GRAM, one.lump), (STRAINS, one.strain),
        )  # fmt: skip
        tape += [(int(table[n, column]), part) for column, part in parts]
        constants = eights(int(table[n, PIECES]) + one.element.size)
    modal = np.zeros(constants + 24)
    for place, part in tape:
        modal[place : place + part.size] = part.ravel()
    return table, modal
