"""Closed forms and tables: beams that spin steadily."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flexsim_node import load_scene, natural_frequencies

from .comparison import FORMULATIONS, Comparison, Row, both
from .loaded_beams import torsion_constant

FLAP = {0.0: (3.51602, 22.0345, 61.6972), 2.0: (4.13732, 22.6149, 62.2732), 5.0: (6.44954, 25.4461, 65.2050)}
FLAP_ON_A_HUB = (8.94036, 29.3528, 69.7607)
"""Over sqrt(E I / (m L^4)), by spin over the same; on a hub as large as the beam is long at 5."""
SIDE, LENGTH = 0.01, 2.0


def cantilever(formulation: str, ratio: float, hub: float = 0.0) -> np.ndarray:
    """(6,) frequencies of a square beam over sqrt(E I / (m L^4)), rising."""
    unit = np.sqrt(2e11 * SIDE**2 / 12 / 7800 / LENGTH**4)
    part = {
        "name": "beam",
        "dh": {"a": LENGTH},
        "joint": {"type": "fixed"} if hub else {"name": "root"},
        "beam": {"width": SIDE, "depth": SIDE, "density": 7800.0, "youngs_modulus": 2e11, "elements": 12},
    }
    links = [{"name": "hub", "dh": {"a": hub}}, part] if hub else [part]
    made = spinning(formulation, links, effects={"rotary_inertia": False})
    return natural_frequencies(made, [0.0], velocity=[ratio * unit])[:6] * 2 * np.pi / unit


def spinning(formulation: str, links: list[dict], **keys: Any) -> Any:
    """A weightless scene."""
    return load_scene(
        {
            "model": "robot",
            "name": "spinning",
            "gravity": [0.0, 0.0, 0.0],
            "formulation": formulation,
            "links": links,
            **keys,
        }
    )


PLATE = {"length": 0.3, "side": 0.003, "inertia": (3e-5, 1e-6, 3.1e-5)}


def plate(formulation: str, spin: float) -> float:
    """Twisting frequency, Hz, of a flat plate on a thin rod that spins in the plate's plane."""
    rod = {
        "name": "rod",
        "dh": {"a": PLATE["length"]},
        "joint": {"name": "root"},
        "beam": {
            "width": PLATE["side"],
            "depth": PLATE["side"],
            "density": 11.0,
            "youngs_modulus": 7e10,
            "elements": 4,
        },
        "payload": {"mass": 0.02, "inertia": np.diag(PLATE["inertia"]).tolist()},
    }
    found = natural_frequencies(spinning(formulation, [rod]), [0.0], velocity=[spin])
    return float(found[np.argmin(np.abs(found - plate_right(spin)))])


def plate_right(spin: float) -> float:
    """sqrt(G J / L + spin^2 (Izz - Iyy)) / Ixx: the propeller moment, or tennis-racquet effect."""
    along, across, flat = PLATE["inertia"]
    spring = 7e10 / 2.6 * torsion_constant(PLATE["side"], PLATE["side"]) / PLATE["length"]
    return float(np.sqrt((spring + spin**2 * (flat - across)) / along) / 2 / np.pi)


BEYOND = {"length": 0.6, "width": 0.03, "depth": 0.002, "arm": 0.25, "mass": 0.5}


def beyond_the_tip(formulation: str, spin: float) -> float:
    """First frequency, Hz, of a mass on a rigid arm beyond the tip of a spinning strip."""
    strip = {
        "name": "strip",
        "dh": {"a": BEYOND["length"]},
        "joint": {"name": "root"},
        "beam": {
            "width": BEYOND["width"],
            "depth": BEYOND["depth"],
            "density": 10.001,
            "youngs_modulus": 7e10,
            "elements": 12,
        },
    }
    arm = {
        "name": "arm",
        "dh": {"a": BEYOND["arm"]},
        "joint": {"type": "fixed"},
        "rigid": {"mass": BEYOND["mass"]},
    }
    return natural_frequencies(spinning(formulation, [strip, arm]), [0.0], velocity=[spin])[0]


def beyond_right(spin: float) -> float:
    """A massless strip, pulled by P = m spin^2 (L + c), with the mass at the distance c beyond its end.

    E I w'''' - P w'' = 0 for a unit of force and moment at the end; the arm's pull adds P c to the end's
    turning stiffness.
    """
    length, c, mass = BEYOND["length"], BEYOND["arm"], BEYOND["mass"]
    bending, pull = 7e10 * BEYOND["width"] * BEYOND["depth"] ** 3 / 12, mass * spin**2 * (length + c)
    a = np.sqrt(pull / bending)
    cosh, sinh = np.cosh(a * length), np.sinh(a * length)
    shape = np.array([[cosh - 1, sinh - a * length], [a * sinh, a * (cosh - 1)]])
    moment = bending * np.array([a**2 * cosh, a**2 * sinh])
    shear = -bending * np.array([a**3 * sinh, a**3 * cosh]) + pull * shape[1]
    stiffness = np.array([shear, moment]) @ np.linalg.inv(shape)
    stiffness[1, 1] += pull * c
    lever = np.array([1.0, c])
    return float(np.sqrt(1.0 / (lever @ np.linalg.solve(stiffness, lever)) / mass) / 2 / np.pi)


def compare() -> Comparison:
    """Flap and lag, hub, propeller moment, body beyond the tip."""
    rows = []
    for ratio, flap in FLAP.items():
        found = {f: cantilever(f, ratio) for f in FORMULATIONS}
        right = np.sort(np.concatenate([flap, np.sqrt(np.square(flap) - ratio**2)]))
        for k, value in enumerate(right):
            kind = "flap" if np.min(np.abs(np.array(flap) - value)) < 1e-9 else "lag"
            if ratio == 0.0 and k % 2:
                continue
            rows.append(
                Row(
                    f"{kind}, spin ratio {ratio:g}",
                    "√(EI/mL⁴)",
                    float(value),
                    {f: float(found[f][k]) for f in FORMULATIONS},
                )
            )
    found = {f: cantilever(f, 5.0, LENGTH) for f in FORMULATIONS}
    rows += [
        Row(
            "flap, spin ratio 5, hub ratio 1",
            "√(EI/mL⁴)",
            value,
            {f: float(found[f][np.argmin(np.abs(found[f] - value))]) for f in FORMULATIONS},
        )
        for value in FLAP_ON_A_HUB
    ]
    rows += [
        Row(
            f"twist of a flat plate on a rod, {w:g} rad/s",
            "Hz",
            plate_right(w),
            both(lambda f, w=w: plate(f, w)),
        )
        for w in (40.0, 80.0)
    ]
    rows += [
        Row(
            f"mass on a rigid arm 0.25 m beyond a strip's tip, {w:g} rad/s",
            "Hz",
            beyond_right(w),
            both(lambda f, w=w: beyond_the_tip(f, w)),
        )
        for w in (10.0, 40.0, 60.0)
    ]
    return Comparison(
        "Beams that spin",
        "closed form",
        "Wright et al., J. Applied Mechanics 49 (1982) 197, flap; lag² = flap² - spin²; (GJ/L +"
        " Ω²(Izz - Iyy))/Ixx;"
        " the differential equation of a pulled beam",
        "Frequencies about the steady shape (`natural_frequencies(..., velocity=...)`), 12"
        " elements; the plate's"
        " stiffness is the propeller moment, or tennis-racquet effect.",
        "The elements.",
        rows,
    )


def draw(comparison: Comparison, figure: Figure) -> None:
    """Differences of all rows."""
    panel = figure.subplots()
    for name, style, shift in (("erls", "C0o", -0.1), ("co_moving", "C1s", 0.1)):
        sizes = [max(abs(r.difference(name) or 0.0), 1e-7) for r in comparison.rows]
        panel.semilogy(np.arange(len(sizes)) + shift, sizes, style, markersize=4, label=name)
    panel.axhline(5e-3, color="k", linewidth=0.8)
    panel.set(xlabel="row of the table", ylabel="difference, relative")
    panel.legend(fontsize=8)
