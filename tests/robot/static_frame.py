"""Statics of a frame of geometrically exact beams (Simo 1985), by shooting from its clamped end.

The weights are dead loads, so that the force in every section is known beforehand; unknown is the moment at
the clamp, found so that the free end has none.  Nothing is taken from flexsim_node.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root


def cross_matrix(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def frame_ends(legs, gravity, tip_mass=0.0):
    """(L, 3) ends of a chain of beams under their own weight, clamped at the origin.

    legs : dicts with `turn` (3, 3), from the leg before (of the first the base) to the beam axes, length,
    line_mass (kg/m), stiffness (EA, GJ, EI_y, EI_z); no shear
    """
    gravity = np.asarray(gravity)
    beyond = [tip_mass + sum(x["length"] * x["line_mass"] for x in legs[k + 1 :]) for k in range(len(legs))]

    def march(moment):
        place, turn, ends = np.zeros(3), np.eye(3), []
        for leg, carried in zip(legs, beyond, strict=True):
            turn = turn @ leg["turn"]
            axial, *bend = leg["stiffness"]

            def slope(s, y, leg=leg, carried=carried, axial=axial, bend=tuple(bend)):
                r = y[3:12].reshape(3, 3)
                force = (carried + leg["line_mass"] * (leg["length"] - s)) * gravity
                stretch = 1.0 + (r.T @ force)[0] / axial
                tangent = stretch * r[:, 0]
                curvature = (r.T @ y[12:]) / bend
                return np.concatenate(
                    [tangent, (r @ cross_matrix(curvature)).ravel(), -np.cross(tangent, force)]
                )

            start = np.concatenate([place, turn.ravel(), moment])
            y = solve_ivp(slope, (0.0, leg["length"]), start, rtol=1e-10, atol=1e-12).y[:, -1]
            place, turn, moment = y[:3], y[3:12].reshape(3, 3), y[12:]
            ends.append(place)
        return np.array(ends), moment

    found = root(lambda m: march(m)[1], np.zeros(3), tol=1e-12)
    assert found.success, found.message
    return march(found.x)[0]
