"""What the validity watch holds a motion against: the scene's limits, and the links' slenderness."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ..elements.element import stiffening
from ..elements.section import section
from ..scene.load import Scene
from ..scene.schema import Link

LEFT_OUT = 0.1  # of the stiffness, taken by loads of which the equations know nothing: a warning


def watch_limits(scene: Scene) -> np.ndarray:
    """(7, 2) of the scene's validity: warn and stop, infinite where there is none."""
    v = scene.validity
    rows = [v.elastic_rotation, v.spin_ratio, v.correction, v.axial_load, v.erls_condition, v.mass_condition]
    rows.append(v.load_stiffness)
    limits = np.array([[np.inf if x is None else x for x in (row.warn, row.stop)] for row in rows])
    if stiffening(scene):
        limits[1], limits[3, 1] = np.inf, np.inf
    elif not scene.co_moving:
        limits[6, 0] = min(limits[6, 0], LEFT_OUT)
    return limits


def slender_limits(scene: Scene, link: Link, beyond: float, planar: bool) -> tuple[float, float]:
    """First bending frequency (rad/s) and buckling load (N) of a link as a cantilever; zero for a rigid one.

    `beyond` is the mass (kg) at its end.  The frequency is the root of
    1 + cos k cosh k + mu k (cos k sinh k - sin k cosh k) = 0 with mu = beyond / mass
    (Blevins, Formulas for Natural Frequency and Mode Shape, 1979,
    table 8-8), the load pi^2 E I / (4 L^2); both with the weaker of the bendings that are on.
    """
    effects, beam = scene.effects, link.beam
    bends_y = effects.bending_y and not planar
    if beam is None or not link.flexible or not (bends_y or effects.bending_z):
        return 0.0, 0.0
    s = section(beam)
    weaker = min(i for i, on in ((s.iz, effects.bending_z), (s.iy, bends_y)) if on)
    mass = beam.density * s.area * link.length
    mu = beyond / mass

    def characteristic(k: float) -> float:
        c, h, sn, sh = np.cos(k), np.cosh(k), np.sin(k), np.sinh(k)
        return float(1.0 + c * h + mu * k * (c * sh - sn * h))

    k = brentq(characteristic, 1e-6, 1.8752)
    rigidity = beam.youngs_modulus * weaker
    load = np.pi**2 * rigidity / (4.0 * link.length**2) if effects.axial else 0.0
    return float(k**2 * np.sqrt(rigidity / (mass * link.length**3))), load


def link_mass(link: Link) -> float:
    """Mass of a link with its bodies, kg."""
    own = link.beam.density * section(link.beam).area * link.length if link.beam else 0.0
    return own + sum(body.mass for body in (link.rigid, link.payload) if body)
