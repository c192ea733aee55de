"""Programs: the Princeton beam's load, against the frame program of the tests."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flexsim_node import load_scene, static_equilibrium

from .comparison import Comparison, Row, both

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "robot"))
from independent_frame import extrapolated, frame_of_scene, link_ends

LENGTH, HEIGHT, THICKNESS, YOUNG, POISSON = 0.508, 12.3777e-3, 3.2024e-3, 71.7e9, 0.31
LOADS, ANGLES = (4.448, 8.896, 13.345), (0.0, 30.0, 45.0, 60.0, 90.0)


def scene(load: float, angle: float, formulation: str, elements: int = 12) -> Any:
    """The beam along x with a weight `load` (N) at its end; at 0 degrees it hangs down across the height."""
    turn = np.radians(angle)
    down = [0.0, -9.81 * np.cos(turn), -9.81 * np.sin(turn)]
    section = {"width": HEIGHT, "depth": THICKNESS, "density": 10.001}
    material = {"youngs_modulus": YOUNG, "poissons_ratio": POISSON, "elements": elements}
    link = {
        "name": "beam",
        "dh": {"a": LENGTH},
        "joint": {"name": "root"},
        "beam": {**section, **material},
        "payload": {"mass": load / 9.81},
    }
    return load_scene(
        {"model": "robot", "name": "princeton", "gravity": down, "formulation": formulation, "links": [link]}
    )


def flexsim_tip(load: float, angle: float, formulation: str, elements: int = 12) -> np.ndarray:
    """(3,) displacement of the end, m: along, across the height, across the thickness."""
    found = static_equilibrium(scene(load, angle, formulation, elements), [0.0])
    return found.link_end[-1] - np.array([LENGTH, 0.0, 0.0])


@cache
def frame_tip(load: float, angle: float) -> tuple[float, ...]:
    """The same by the frame program."""

    def at(count: int) -> np.ndarray:
        frame, names = frame_of_scene(scene(load, angle, "erls"), [0.0], count)
        return link_ends(frame.solved(), names)[-1] - np.array([LENGTH, 0.0, 0.0])

    return tuple(extrapolated(at, 8))


def compare() -> Comparison:
    """Both displacements of the end under the largest load, and of a third of it at 45 degrees."""
    rows = []
    for load, angle in [(LOADS[0], 45.0), *((LOADS[2], a) for a in ANGLES)]:
        for k, name in ((1, "across its height"), (2, "across its thickness")):
            right = frame_tip(load, angle)[k]
            if abs(right) < 1e-9:
                continue
            found = both(lambda f, k=k, load=load, angle=angle: flexsim_tip(load, angle, f)[k])
            rows.append(Row(f"{load:g} N at {angle:g}°, end {name}", "m", right, found))
    return Comparison(
        "The Princeton beam",
        "program",
        "tests/robot/independent_frame.py: geometrically exact beams, extrapolated; the beam and"
        " its loads are"
        " those of Dowell & Traybar's experiments (1975) as Exudyn's examples have them",
        "A strip of aluminium, 508 x 12.38 x 3.2 mm, with a weight on its end that is turned about its axis:"
        " bending one way, through the torsion, changes bending the other way. The experiment's own figures"
        " are not at hand, so this compares programs.",
        "The end turns by up to 0.6 rad: of `erls`, the squared rotation; it warns there. Of `co_moving`, 12"
        " elements.",
        rows,
    )


def draw(comparison: Comparison, figure: Figure) -> None:
    """Both displacements over the load's angle, largest load."""
    panel = figure.subplots()
    rows = [r for r in comparison.rows if r.quantity.startswith(f"{LOADS[2]:g} N")]
    for word, marker in (("height", "o"), ("thickness", "s")):
        chosen = [r for r in rows if r.quantity.endswith(word)]
        angles = [float(r.quantity.split(" at ")[1].split("°")[0]) for r in chosen]
        panel.plot(
            angles,
            [abs(r.reference) for r in chosen],
            f"k{marker}-",
            mfc="none",
            label=f"frame, across {word}",
        )
        for name, style in (("erls", "C0:"), ("co_moving", "C1--")):
            far = [abs(r.found[name]) if r.found[name] is not None else np.nan for r in chosen]
            panel.plot(angles, far, style + marker, markersize=4, label=f"{name}, across {word}")
    panel.set(xlabel="angle of the weight, degrees", ylabel="displacement of the end, m")
    panel.legend(fontsize=7)
