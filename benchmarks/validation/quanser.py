"""Measured: the deflections of Quanser's two-link robot, driven by its measured joint angles."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline
from scipy.signal import TransferFunction, butter, filtfilt, lsim

from flexsim_node import load_scene, simulate

from .comparison import DATA, FORMULATIONS, Comparison, Row

INCH = 0.0254
YOUNG = 2.068427e11
LENGTH, THICKNESS = (0.202, 0.20185), (0.050 * INCH, 0.035 * INCH)
HALF = 9.8  # s


def table() -> np.ndarray:
    """(K, 5) time, s; joint 1, deflection of link 1, joint 2, deflection of link 2, rad."""
    return np.loadtxt(DATA / "quanser_2dsfl.csv", delimiter=",", skiprows=4)


def scene(formulation: str) -> Any:
    """The documented robot; the hubs of 79 mm before the strips and the 50 mm behind the first are not."""
    steel = {"density": 7800.0, "youngs_modulus": YOUNG, "elements": 2}
    fixed = {"type": "fixed"}
    links = [
        {"name": "hub_1", "dh": {"a": 0.079}, "joint": {"name": "joint_1"}},
        {
            "name": "link_1",
            "dh": {"a": LENGTH[0]},
            "joint": fixed,
            "beam": {**steel, "width": THICKNESS[0], "depth": 3.0 * INCH},
            "payload": {"mass": 1.578},
        },
        {"name": "clamp", "dh": {"a": 0.05}, "joint": fixed},
        {"name": "hub_2", "dh": {"a": 0.079}, "joint": {"name": "joint_2"}},
        {
            "name": "link_2",
            "dh": {"a": LENGTH[1]},
            "joint": fixed,
            "beam": {**steel, "width": THICKNESS[1], "depth": 1.5 * INCH},
            "payload": {
                "mass": 0.157,
                "inertia": np.diag([0.0, 0.0, 0.157 * (0.0445**2 + 0.0224**2) / 12]).tolist(),
            },
        },
    ]
    links[4]["payload"]["inertia"][0][0] = links[4]["payload"]["inertia"][2][2]
    gauges = [
        {"name": f"gauge_{k}", "type": "strain_gauge", "link": f"link_{k}", "at": 0.0, "side": "-y"}
        for k in (1, 2)
    ]
    return load_scene(
        {
            "model": "robot",
            "name": "quanser_2dsfl",
            "gravity": [0.0, 0.0, 0.0],
            "formulation": formulation,
            "links": links,
            "sensors": gauges,
            "solver": {"step": 2e-3},
        }
    )


def measured_motion(data: np.ndarray) -> dict[str, Any]:
    """Each joint's angle, rate and acceleration: the encoder's staircase smoothed below 10 Hz."""
    smooth = butter(3, 10.0, fs=1.0 / (data[1, 0] - data[0, 0]))
    motion = {}
    for name, column in (("joint_1", 1), ("joint_2", 3)):
        curve = CubicSpline(data[:, 0], filtfilt(*smooth, data[:, column]))
        rate, acceleration = curve.derivative(), curve.derivative(2)
        motion[name] = lambda t, c=curve, r=rate, a=acceleration: (float(c(t)), float(r(t)), float(a(t)))
    return motion


def deflections(formulation: str) -> np.ndarray:
    """(K, 2) deflections as the laboratory has them: strain through its low-pass, less the start."""
    data = table()
    run = simulate(
        scene(formulation), duration=data[-1, 0], sample_period=0.01, prescribed=measured_motion(data)
    )
    assert run.status == "ok", run.status
    low_pass = TransferFunction([157.91], [1.0, 22.62, 157.91])
    columns = []
    for k, quiet in ((0, 1.0), (1, 0.2)):
        strain = run.sensors[f"gauge_{k + 1}"].reshape(len(run.time), -1)[:, 0]
        raw = 2.0 / 3.0 * LENGTH[k] / THICKNESS[k] * strain
        _, filtered, _ = lsim(low_pass, raw, run.time)
        columns.append(filtered - np.mean(filtered[run.time <= quiet]))
    return np.column_stack(columns)


def accounted(right: np.ndarray, found: np.ndarray) -> float:
    """Part of the variance of `right` that `found` accounts for, %."""
    return float(100.0 * (1.0 - np.var(right - found) / np.var(right)))


def compare() -> Comparison:
    """Both strains on the second half of the run, with documented parameters."""
    data = table()
    found = {name: deflections(name) for name in FORMULATIONS}
    late = data[:, 0] >= HALF
    rows = [
        Row(
            f"variance of link {k + 1}'s deflection accounted for, last {data[-1, 0] - HALF:.1f} s",
            "%",
            100.0,
            {name: accounted(data[late, c], found[name][late, k]) for name in FORMULATIONS},
            absolute=True,
        )
        for k, c in ((0, 2), (1, 4))
    ]
    thin = slice(None, None, 4)
    curves = {
        "time": np.round(data[thin, 0], 3).tolist(),
        "measured": np.round(data[thin][:, [2, 4]], 6).tolist(),
        **{name: np.round(found[name][thin], 6).tolist() for name in FORMULATIONS},
    }
    return Comparison(
        "Quanser's two-link robot with flexible links",
        "measured",
        "Quanser's own recording, github.com/basta/quanser-2-dof-serial-flexible-link (MIT licence)",
        "Two steel strips in a horizontal plane, 19.6 s. The joints follow the encoders; the strain at each"
        " clamp, through the laboratory's own 2 Hz low-pass, is compared with its gauges. All parameters are"
        " the documented ones, nothing is fitted.",
        "The parameters: where the strips are clamped, how far the second axis stands from the first strip's"
        " end and the gauges' gains are not documented. A fit of six of them on the first half of another"
        " such study brought 88 % of both; the clamps' softness and the structural damping are unknown. Both"
        " formulations give the same curve, so theirs is not the error.",
        rows,
        curves,
    )


def draw(comparison: Comparison, figure: Figure) -> None:
    """Both deflections over time."""
    panels = figure.subplots(2, 1, sharex=True)
    curves = {k: np.array(v) for k, v in comparison.curves.items()}
    for k, panel in enumerate(panels):
        panel.plot(curves["time"], 1e3 * curves["measured"][:, k], "k", linewidth=1.4, label="measured")
        for name, style in (("erls", "C0-"), ("co_moving", "C1--")):
            panel.plot(curves["time"], 1e3 * curves[name][:, k], style, linewidth=1.0, label=name)
        panel.set_ylabel(f"link {k + 1}, mrad")
    panels[1].set_xlabel("s")
    panels[0].legend(fontsize=8, ncols=3)
