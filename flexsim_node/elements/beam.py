"""The beam element: two nodes, Hermite cubics, in the beam axes of its link.

Inside a link every point moves as p = o + R (x + N(x) d).  The centreline of an element is a cubic
with the Hermite coefficients (value, length * slope) at its two ends, so it is held as four vectors
rho_a, and the directors of the section (images of the unit vectors e_y, e_z, turned by the linear
rotation phi) as three vectors each, at the two ends and the middle.  All inertia terms then follow
from constant mass matrices between these vectors; nothing of the displacement field is left out:

    p'' = a + B rho + 2 omega x c' + c'',    B = [alpha]x + [omega]x [omega]x

Nodal dofs: spatial (ux, uy, uz, rx, ry, rz), planar (ux, uy, rz).  With Timoshenko shear the slope of
the centreline is the section's rotation plus the shear strain
gamma = s ((w2 - w1)/length - mean rotation), s = Phi/(1 + Phi) (Przemieniecki, Theory of Matrix
Structural Analysis, 1968, section 5.6); s = 0 is Euler-Bernoulli.

With the `centrifugal` effect the axial strain of an element carries the mean of the squared slope,
(u2 - u1)/length + mean(w'^2)/2 (von Karman's strain, averaged so that it does not lock): the
geometric stiffness of whatever axial force is there, derived from an energy.  Where it twists, fibres
beside the axis are helices: (I_p/A) (x2 - x1)^2/(2 length^2) on average (second_order.md, T2).  Inside an
element the squared slope is not uniform: that moves its mass along the beam by
s = length (phi2^2 - phi1^2)/24 on average (phi the sections' rotations at its start and end), which the
inertia terms carry.  So an axial force that varies along the element stiffens it as it should.
"""

from __future__ import annotations

import numpy as np

from ..compiled.kernel import kernel

# columns of Chain.element
START, LENGTH, MASS, INERTIA_Y, INERTIA_Z, POLAR = 0, 1, 2, 3, 4, 5
AXIAL, TORSION, BEND_Y, BEND_Z, SHEAR_Y, SHEAR_Z, STIFFENING, TURNING = 6, 7, 8, 9, 10, 11, 12, 13
HELIX = 14
# (BEND_Z, SHEAR_Z bend in the x-y plane, about z; BEND_Y, SHEAR_Y in the x-z plane, about y.
#  INERTIA_Y, INERTIA_Z are density times the integrals of y^2 and of z^2 over the section.)
# STIFFENING: 1 where the squared slope stretches the element; TURNING: 1 where its strains and sections turn
# to second order too (spatial_strain.py, section_turn.py). HELIX: I_p/A, m2, where twist stretches it.
COLUMNS = 15

HERMITE_MASS = (
    np.array(
        [
            [156.0, 22.0, 54.0, -13.0],
            [22.0, 4.0, 13.0, -3.0],
            [54.0, 13.0, 156.0, -22.0],
            [-13.0, -3.0, -22.0, 4.0],
        ]
    )
    / 420.0
)
QUADRATIC_MASS = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30.0


@kernel
def hermite_mass(mass, f0, f1, f2, f3):
    """Products of HERMITE_MASS with four scalar coefficients, times `mass`."""
    m = mass / 420.0
    return (
        m * (156.0 * f0 + 22.0 * f1 + 54.0 * f2 - 13.0 * f3),
        m * (22.0 * f0 + 4.0 * f1 + 13.0 * f2 - 3.0 * f3),
        m * (54.0 * f0 + 13.0 * f1 + 156.0 * f2 - 22.0 * f3),
        m * (-13.0 * f0 - 3.0 * f1 - 22.0 * f2 + 4.0 * f3),
    )


@kernel
def quadratic_mass(inertia, f0, f1, f2):
    """Products of QUADRATIC_MASS with three scalar values (start, middle, end), times `inertia`."""
    j = inertia / 30.0
    return (
        j * (4.0 * f0 + 2.0 * f1 - f2),
        j * (2.0 * f0 + 16.0 * f1 + 2.0 * f2),
        j * (-f0 + 2.0 * f1 + 4.0 * f2),
    )


@kernel
def hermite(w1, t1, w2, t2, length, s):
    """Hermite coefficients of a centreline from end deflections and section rotations."""
    shear = s * (w2 - w1 - 0.5 * length * (t1 + t2))
    return w1, length * t1 + shear, w2, length * t2 + shear


@kernel
def hermite_transpose(g0, g1, g2, g3, length, s):
    """Forces on (w1, t1, w2, t2) from forces on the Hermite coefficients."""
    shear = s * (g1 + g3)
    return (
        g0 - shear,
        length * (g1 - 0.5 * shear),
        g2 + shear,
        length * (g3 - 0.5 * shear),
    )


@kernel
def middle_rotation(w1, t1, w2, t2, length, s):
    """Rotation of the section at the middle of an element."""
    return 1.5 * (1.0 - s) * (w2 - w1) / length - (0.25 - 0.75 * s) * (t1 + t2)


@kernel
def squared_slope(w1, t1, w2, t2, length, s):
    """Mean of w'^2 over an element and its halved gradient with respect to (w1, t1, w2, t2)."""
    h0, h1, h2, h3 = hermite(w1, t1, w2, t2, length, s)
    chord = h2 - h0
    scale = 1.0 / (30.0 * length * length)
    g_chord = scale * (36.0 * chord - 3.0 * (h1 + h3))
    g1 = scale * (4.0 * h1 - h3 - 3.0 * chord)
    g3 = scale * (4.0 * h3 - h1 - 3.0 * chord)
    mean = g_chord * chord + g1 * h1 + g3 * h3
    b0, b1, b2, b3 = hermite_transpose(-g_chord, g1, g_chord, g3, length, s)
    return mean, b0, b1, b2, b3


@kernel
def pull_stiffness(pull, length, s):
    """What a pull, force times length, adds to a bent element's stiffness.

    For (w, w), (w, t), (t, t) and (t, t') of displacements w and rotations t at the ends.  The mean squared
    slope is psi^2 + (1 - s)^2 (psi - m)^2/5 + delta^2/3, with the chord's slope psi, mean and half
    difference m, delta of the sections' rotations.
    """
    skew = 0.2 * (1.0 - s) * (1.0 - s) * pull
    return (
        (pull + skew) / (length * length),
        0.5 * skew / length,
        0.25 * skew + pull / 12.0,
        0.25 * skew - pull / 12.0,
    )


@kernel
def squared_helix(e, x1, x2):
    """(I_p/A) times the squared twist per length, of the ends' twists, and its halved gradient by x2."""
    gradient = e[HELIX] * (x2 - x1) / (e[LENGTH] * e[LENGTH])
    return gradient * (x2 - x1), gradient


@kernel
def shift(e, t1, t2):
    """How far the squared slope of end rotations t1, t2 moves an element's mass along the beam."""
    return e[LENGTH] * (t2 * t2 - t1 * t1) / 24.0


@kernel
def bending_force(stiffness, w1, t1, w2, t2, length, s):
    """Elastic forces on (w1, t1, w2, t2); `stiffness` is E I / length."""
    curvature = stiffness * (t2 - t1)
    skew = 12.0 * (1.0 - s) * stiffness * ((w2 - w1) / length - 0.5 * (t1 + t2))
    return (
        -skew / length,
        -curvature - 0.5 * skew,
        skew / length,
        curvature - 0.5 * skew,
    )


@kernel
def stiffening_energy(e, p, r):
    """What the mean squared slopes add to the strain energy; p, r are spatial rows (6,)."""
    length = e[LENGTH]
    my, _, _, _, _ = squared_slope(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    mz, _, _, _, _ = squared_slope(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    mx, _ = squared_helix(e, p[3], r[3])
    shortening = 0.5 * length * (mx + my + mz)
    return e[AXIAL] * shortening * (r[0] - p[0] + 0.5 * shortening)


def hermite_matrix(length: float, s: float) -> np.ndarray:
    """(4, 4) map of (w1, t1, w2, t2) to the Hermite coefficients."""
    return np.array([hermite(*row, length, s) for row in np.eye(4)]).T


def bending_stiffness(stiffness: float, length: float, s: float) -> np.ndarray:
    """(4, 4) stiffness matrix over (w1, t1, w2, t2); `stiffness` is E I / length (N m)."""
    return np.array([bending_force(stiffness, *row, length, s) for row in np.eye(4)]).T
