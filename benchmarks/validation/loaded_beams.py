"""Closed forms: beams under the weight of what they carry."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flexsim_node import load_scene, natural_frequencies

from .comparison import FORMULATIONS, Comparison, Row, attempted, both

G = 9.81
POISSON = 0.3


def torsion_constant(long: float, short: float) -> float:
    """Saint-Venant's constant of a rectangle (Timoshenko & Goodier, Theory of Elasticity, 109), m4."""
    k = np.arange(1, 400, 2)
    series = np.sum(np.tanh(0.5 * k * np.pi * long / short) / k**5)
    return float(long * short**3 * (1 / 3 - 64 / np.pi**5 * short / long * series))


def beam(length: float, width: float, depth: float, young: float, elements: int, **keys: Any) -> dict:
    """A link along x with hardly any mass of its own."""
    section = {"width": width, "depth": depth, "density": 10.001, "youngs_modulus": young}
    return {
        "name": keys.pop("name", "beam"),
        "dh": {"a": length, **keys.pop("dh", {})},
        "joint": keys.pop("joint", {"name": "root"}),
        "beam": {**section, "poissons_ratio": POISSON, "elements": elements},
        **keys,
    }


def scene(formulation: str, *links: dict) -> Any:
    """Links under weight along -y."""
    return load_scene(
        {
            "model": "robot",
            "name": "loaded",
            "gravity": [0.0, -G, 0.0],
            "formulation": formulation,
            "links": list(links),
        }
    )


# A rod's twist with a body above or below
ROD = {"length": 0.5, "side": 0.006, "young": 7e10, "mass": 1.0, "arm": 0.4}


def twist(formulation: str, sign: float) -> float:
    """First twisting frequency, Hz, with the body above (+1) or below (-1) the rod's axis."""
    payload = {
        "mass": ROD["mass"],
        "center_of_mass": [0.0, sign * ROD["arm"], 0.0],
        "inertia": (1e-6 * np.eye(3)).tolist(),
    }
    rod = beam(ROD["length"], ROD["side"], ROD["side"], ROD["young"], 4, payload=payload)
    stiff = {"bending_y": False, "bending_z": False}
    made = scene(formulation, rod)
    if formulation == "co_moving":
        stiff["axial"] = False
    effects = made.effects.model_copy(update=stiff)
    return natural_frequencies(made.model_copy(update={"effects": effects}), [0.0], loaded=True)[0]


def twist_right(sign: float) -> float:
    """sqrt((G J / L - sign m g h) / I) / 2 pi."""
    spring = ROD["young"] / 2 / (1 + POISSON) * torsion_constant(ROD["side"], ROD["side"]) / ROD["length"]
    inertia = ROD["mass"] * ROD["arm"] ** 2 + 1e-6
    return float(np.sqrt((spring - sign * ROD["mass"] * G * ROD["arm"]) / inertia) / 2 / np.pi)


# A column that carries a rigid rod, upright or folded down
COLUMN = {"length": 0.5, "side": 0.01, "young": 7e10, "rod": 0.4, "mass": 1.0}


def column(formulation: str, folded: bool) -> float:
    """First frequency, Hz, of an upright beam with a rigid rod on it that stands on or hangs down."""
    post = beam(COLUMN["length"], COLUMN["side"], COLUMN["side"], COLUMN["young"], 8)
    rod = {
        "name": "rod",
        "dh": {"a": COLUMN["rod"], "theta": np.pi * folded},
        "joint": {"type": "fixed"},
        "rigid": {"mass": COLUMN["mass"], "center_of_mass": [-0.5 * COLUMN["rod"], 0.0, 0.0]},
    }
    return natural_frequencies(scene(formulation, post, rod), [0.5 * np.pi], loaded=True)[0]


def column_right(folded: bool) -> float:
    """A massless beam-column, pressed by P = m g, with a mass at the distance c beyond its end.

    E I w'''' + P w'' = 0 is solved for a unit of sideways force and moment at the end; the rigid rod's weight
    adds -P c to the end's turning stiffness. One mass moves, so that one frequency is left.
    """
    c = (-0.5 if folded else 0.5) * COLUMN["rod"]
    bending, press, length = COLUMN["young"] * COLUMN["side"] ** 4 / 12, COLUMN["mass"] * G, COLUMN["length"]
    a = np.sqrt(press / bending)
    # w = A (cos ax - 1) + B (sin ax - a x): moment E I w'' and sideways force of the end from w
    cos, sin = np.cos(a * length), np.sin(a * length)
    shape = np.array([[cos - 1, sin - a * length], [-a * sin, a * (cos - 1)]])
    moment = bending * np.array([-(a**2) * cos, -(a**2) * sin])
    shear = -bending * np.array([a**3 * sin, -(a**3) * cos]) - press * shape[1]
    stiffness = np.array([shear, moment]) @ np.linalg.inv(shape)
    stiffness[1, 1] -= press * c
    lever = np.array([1.0, c])
    flexibility = lever @ np.linalg.solve(stiffness, lever)
    return float(np.sqrt(1.0 / flexibility / COLUMN["mass"]) / 2 / np.pi)


# Lateral buckling of a deep strip
STRIP = {"length": 0.6, "height": 0.04, "thickness": 0.001, "young": 2e11}


def critical() -> float:
    """4.0126 sqrt(E I G J) / L^2 (Timoshenko & Gere, Theory of Elastic Stability, 6.3), N."""
    bending = STRIP["young"] * STRIP["height"] * STRIP["thickness"] ** 3 / 12
    torsion = STRIP["young"] / 2 / (1 + POISSON) * torsion_constant(STRIP["height"], STRIP["thickness"])
    return float(4.0126 * np.sqrt(bending * torsion) / STRIP["length"] ** 2)


@cache
def sideways(formulation: str, part: float) -> float:
    """Stiffness of the strip's end across its height, of itself without load, under a part of that load."""
    mass = part * critical() / G
    strip = beam(
        STRIP["length"], STRIP["height"], STRIP["thickness"], STRIP["young"], 16, payload={"mass": mass}
    )
    squared = natural_frequencies(scene(formulation, strip), [0.0], loaded=True)[0] ** 2 * mass
    bending = STRIP["young"] * STRIP["height"] * STRIP["thickness"] ** 3 / 12
    return float(squared * 4 * np.pi**2 * STRIP["length"] ** 3 / 3 / bending)


def buckling_load(formulation: str) -> float:
    """Load, of the critical one, at which the sideways stiffness is gone: from 0.9 on by its square."""
    near, nearer = sideways(formulation, 0.9), sideways(formulation, 0.95)
    if near - nearer < 1e-3:
        raise ArithmeticError("does not soften")
    return float(np.sqrt(0.95**2 + (0.95**2 - 0.9**2) * nearer / (near - nearer)))


# Euler's column
def euler(formulation: str, part: float) -> float:
    """First frequency, Hz, of a column with a mass on top, under a part of Euler's load."""
    post = beam(0.5, 0.004, 0.02, 2e11, 8, payload={"mass": part * euler_load() / G})
    return natural_frequencies(scene(formulation, post), [0.5 * np.pi], loaded=True)[0]


def euler_load() -> float:
    """pi^2 E I / (4 L^2), N."""
    return float(np.pi**2 * 2e11 * 0.02 * 0.004**3 / 12 / 4 / 0.25)


def euler_right(part: float) -> float:
    """Stiffness P c / (tan c L - c L), c^2 = P / E I, of the loaded end."""
    press = part * euler_load()
    c = np.sqrt(press / (2e11 * 0.02 * 0.004**3 / 12))
    stiffness = press * c / (np.tan(0.5 * c) - 0.5 * c)
    return float(np.sqrt(stiffness / (press / G)) / 2 / np.pi)


def compare() -> Comparison:
    """All four."""
    rows = [
        *(
            Row(
                f"twisting rod, 1 kg 0.4 m {where} its axis",
                "Hz",
                twist_right(s),
                both(lambda f, s=s: twist(f, s)),
            )
            for s, where in ((1.0, "above"), (-1.0, "below"))
        ),
        *(
            Row(
                f"column with a rigid rod that {how}",
                "Hz",
                column_right(k),
                both(lambda f, k=k: column(f, k)),
            )
            for k, how in ((False, "stands on it"), (True, "hangs from its top"))
        ),
        *(
            Row(
                f"column at {part:g} of Euler's load",
                "Hz",
                euler_right(part),
                both(lambda f, p=part: euler(f, p)),
            )
            for part in (0.5, 0.9)
        ),
        Row("load that buckles a deep strip sideways", "of 4.0126 √(EI GJ)/L²", 1.0, both(buckling_load)),
    ]
    rows[-1].without = "never"
    loads = np.array([0.01, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95])
    curves = {"load": loads.tolist()} | {
        f: [attempted(lambda p=p, f=f: sideways(f, float(p))) for p in loads] for f in FORMULATIONS
    }
    return Comparison(
        "Beams under the weight of what they carry",
        "closed form",
        "(GJ/L ∓ mgh)/I; the differential equation of the beam-column; Euler; Timoshenko & Gere, Theory of"
        " Elastic Stability, 6.3",
        "Frequencies about the static equilibrium (`natural_frequencies(..., loaded=True)`). All"
        " of these loads"
        " act at first order: half the square of an elastic rotation, times the lever, against the weight.",
        "The elements (`co_moving` nears the limit with their second power), the beams' own small"
        " mass and, of"
        " the strip, its sag before it buckles.",
        rows,
        curves,
    )


def draw(comparison: Comparison, figure: Figure) -> None:
    """The strip's stiffness across its height over its load."""
    panel = figure.subplots()
    curves = comparison.curves
    for name, style in (("erls", "C0o-"), ("co_moving", "C1s--")):
        panel.plot(curves["load"], [np.nan if v is None else v for v in curves[name]], style, label=name)
    panel.axvline(1.0, color="k", linewidth=0.8)
    panel.text(0.99, 0.9, "4.0126 √(EI GJ)/L²", ha="right", fontsize=8)
    panel.set(
        xlabel="weight on the end of a deep strip, of the critical one",
        ylabel="stiffness across it, of 3EI/L³",
        ylim=(0, None),
    )
    panel.legend(fontsize=8)
