"""Programs: large motions by geometrically exact beams (tests/robot/data/README.md)."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flexsim_node import load_scene, simulate

from .comparison import FORMULATIONS, Comparison, Row

REFERENCE = Path(__file__).resolve().parents[2] / "tests" / "robot" / "data"
RIGHT_ANGLE = 0.5 * np.pi


def link(name: str, dh: dict[str, float], width: float, depth: float, **beam: float) -> dict[str, Any]:
    """A steel link of the thesis' robots in two elements."""
    steel = {"density": 7800.0, "youngs_modulus": 2.0e11, "poissons_ratio": 0.33, "elements": 2}
    return {"name": name, "dh": dh, "beam": {**steel, "width": width, "depth": depth, **beam}}


def falling(modulus: float, **effects: bool) -> dict[str, Any]:
    """Table 2.3, released from horizontal; effects as the reference has them."""
    table = {"density": 7840.0, "poissons_ratio": 0.3, "youngs_modulus": modulus}
    links = [link("link_1", {"a": 0.5}, 0.03, 0.01, **table), link("link_2", {"a": 0.5}, 0.01, 0.03, **table)]
    return {"gravity": [0.0, -9.81, 0.0], "effects": effects, "links": links}


def driven(modulus: float) -> dict[str, Any]:
    """Table 2.2, 5 sin(2 pi t) N m on joint 1."""
    table = {"youngs_modulus": modulus}
    links = [
        link("link_1", {"d": 0.5, "alpha": RIGHT_ANGLE}, 0.01, 0.03, **table),
        link("link_2", {"a": 0.5}, 0.01, 0.03, **table),
        link("link_3", {"a": 0.5}, 0.01, 0.03, **table),
    ]
    torque = [{"joint": "link_1_joint", "type": "sine", "amplitude": 5.0, "frequency": 1.0}]
    return {"links": links, "torque": torque}


CASES = {
    "falling two-link robot, steel, 1 s": (
        falling(2e11, rotary_inertia=False),
        "falling_two_link_steel.csv",
        1.0,
    ),
    "falling two-link robot, E = 2e9 Pa, 1 s": (falling(2e9, shear=True), "falling_two_link_soft.csv", 1.0),
    "driven anthropomorphic robot, steel, 0.5 s": (driven(2e11), "driven_anthropomorphic_steel.csv", 0.5),
    "driven anthropomorphic robot, E = 5e9 Pa, 0.5 s": (driven(5e9), "driven_anthropomorphic_soft.csv", 0.5),
}


@cache
def distances(case: str, formulation: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Times, and how far any link's end then is from the reference, m."""
    given, file, duration = CASES[case]
    reference = np.loadtxt(REFERENCE / file, delimiter=",")
    scene = load_scene({"model": "robot", "name": "reference", "formulation": formulation, **given})
    run = simulate(scene, duration=duration, sample_period=0.01)
    assert run.status == "ok", run.status
    right = np.zeros(run.link_end.shape)
    dims = (reference.shape[1] - 1) // run.link_end.shape[1]
    right[:, :, :dims] = reference[: len(run.time), 1:].reshape(*run.link_end.shape[:2], dims)
    apart = np.max(np.linalg.norm(run.link_end - right, axis=2), axis=1)
    return tuple(run.time), tuple(apart)


def slewing(formulation: str) -> tuple[np.ndarray, np.ndarray]:
    """Wu & Haug's slewing beam: time, and its tip's deflection from the turning root, m."""
    young, line = 6.895e10, 0.2019
    area, second = 5.03e6 / young, 566.6 / young
    beam = {"area": area, "iy": second, "iz": second, "j": 2 * second}
    beam |= {"density": line / area, "youngs_modulus": young, "elements": 8}
    scene = load_scene(
        {
            "model": "robot",
            "name": "slewing",
            "gravity": [0.0, 0.0, 0.0],
            "formulation": formulation,
            "effects": {"rotary_inertia": False},
            "solver": {"step": 5e-3},
            "links": [{"name": "beam", "dh": {"a": 8.0}, "joint": {"name": "root"}, "beam": beam}],
        }
    )
    run = simulate(scene, duration=20.0, sample_period=0.05, prescribed={"root": slew})
    assert run.status == "ok", run.status
    angle = np.array([slew(t)[0] for t in run.time])
    across = np.column_stack([-np.sin(angle), np.cos(angle)])
    return run.time, np.sum(run.link_end[:, -1, :2] * across, axis=1)


def slew(t: float) -> tuple[float, float, float]:
    """The root's angle, rate and acceleration: to 4 rad/s within 15 s."""
    rate, rise, w = 4.0, 15.0, 2 * np.pi
    s = t / rise
    if s >= 1.0:
        return rate * (t - rise / 2), rate, 0.0
    angle = rate * rise * (s**2 / 2 + (np.cos(w * s) - 1) / w**2)
    return angle, rate * (s - np.sin(w * s) / w), rate / rise * (1 - np.cos(w * s))


def compare() -> Comparison:
    """Largest distances over the runs; the slewing beam's deflection at three times."""
    rows, curves = [], {}
    for case in CASES:
        found = {f: distances(case, f) for f in FORMULATIONS}
        curves[case] = {"time": list(found["erls"][0])} | {f: list(found[f][1]) for f in FORMULATIONS}
        largest = {f: 1e3 * max(found[f][1]) for f in FORMULATIONS}
        rows.append(Row(f"{case}: largest distance of a link's end", "mm", 0.0, largest, absolute=True))
    runs = {f: slewing(f) for f in FORMULATIONS}
    for t, v in ((5.0, -0.4228), (7.5, -0.5205), (10.0, -0.3476)):
        at = {f: float(runs[f][1][round(t / 0.05)]) for f in FORMULATIONS}
        rows.append(Row(f"slewing beam, tip at {t:g} s", "m", v, at))
    curves["slewing"] = {
        "time": runs["erls"][0].tolist(),
        **{f: runs[f][1].tolist() for f in FORMULATIONS},
    }
    return Comparison(
        "Large motions",
        "program",
        "Exudyn 1.13: ANCF cables (falling, slewing: Wu & Haug 1988), geometrically exact beams (driven);"
        " `benchmarks/soft_references.py`",
        "The thesis' robots, two elements a link, 1 ms steps; the slewing beam of 8 m in eight"
        " elements, 5 ms.",
        "Of `erls`, the squared elastic rotation times the length beyond; of both, two elements a link. The"
        " references are converged to about 0.01 mm.",
        rows,
        curves,
    )


def draw(comparison: Comparison, figure: Figure) -> None:
    """Distances over time, and the slewing beam."""
    panels = figure.subplots(1, 2)
    for k, case in enumerate(CASES):
        for name, style in (("erls", "-"), ("co_moving", "--")):
            curve = comparison.curves[case]
            label = case.split(",")[0] + case.split(",")[1] if name == "erls" else None
            far = 1e3 * np.maximum(curve[name], 1e-7)
            panels[0].semilogy(curve["time"], far, style, color=f"C{k}", linewidth=1.1, label=label)
    panels[0].set(xlabel="s", ylabel="distance from the reference, mm", title="- erls, -- co_moving")
    panels[0].legend(fontsize=6)
    reference = np.loadtxt(REFERENCE / "slewing_beam_wu_haug.csv", delimiter=",")
    panels[1].plot(reference[:, 0], reference[:, 2], "k", linewidth=2.0, label="reference")
    for name, style in (("erls", "C0-"), ("co_moving", "C1--")):
        curve = comparison.curves["slewing"]
        panels[1].plot(curve["time"], curve[name], style, linewidth=1.0, label=name)
    panels[1].set(xlabel="s", ylabel="tip of the slewing beam, m")
    panels[1].legend(fontsize=8)
