"""Programs: robots under weight, spin and wrenches, against the frame program of the tests."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from flexsim_node import load_scene, natural_frequencies

from .comparison import FORMULATIONS, Comparison, Row, both

TESTS = Path(__file__).resolve().parents[2] / "tests" / "robot"
sys.path.insert(0, str(TESTS))
from loaded_scenes import SPUN, WEIGHED  # noqa: E402

ELEMENTS = 12


def frequencies(scene: dict, formulation: str, spin: float | None) -> np.ndarray:
    """Lowest frequencies, Hz, under the weight or at the spin."""
    beams = [k for k, link in enumerate(scene["links"]) if "beam" in link]
    read = load_scene(
        scene, {f"links.{k}.beam.elements": ELEMENTS for k in beams} | {"formulation": formulation}
    )
    pose = list(read.start("position"))
    if spin is None:
        return natural_frequencies(read, pose, loaded=True)
    return natural_frequencies(read, pose, velocity=[spin] + [0.0] * (len(pose) - 1))


def compare() -> Comparison:
    """Of each scene the one of its first four frequencies that the load changes most."""
    kept = json.loads((TESTS / "data" / "loaded_frame.json").read_text(encoding="utf-8"))
    rows, unloaded = [], []
    cases = [(f"weighed/{n}", s, None, "under its weight") for n, s in WEIGHED.items()]
    cases += [(f"spun/{n}", s, w, f"at {w:g} rad/s") for n, (s, w) in SPUN.items()]
    for name, scene, spin, how in cases:
        right = np.array(kept[f"{name}/1"]["value"])
        rest = "0" if spin is not None else None
        still = (
            np.array(kept[f"{name}/{rest}"]["value"])
            if rest
            else 0.5 * (np.array(kept[f"{name}/0.1"]["value"]) + np.array(kept[f"{name}/-0.1"]["value"]))
        )
        k = int(np.argmax(np.abs(right / still - 1.0)))
        found = both(lambda f, s=scene, w=spin, k=k: frequencies(s, f, w)[k])
        rows.append(Row(f"{name.split('/')[1]}, {how}: mode {k + 1}", "Hz", float(right[k]), found))
        unloaded.append(float(still[k]))
    return Comparison(
        "Loads on bent ends",
        "program",
        "tests/robot/independent_frame.py: geometrically exact beams, masses lumped, extrapolated; it shares"
        " nothing with flexsim but the scene",
        "Payloads beside the end, rigid bodies and links, branches, links across the load, a prismatic joint"
        " stretched out, under their weight or spinning (tests/robot/loaded_scenes.py); of the"
        " first four modes"
        " the one that the load changes most; 12 elements a link.",
        "Of `co_moving`, the elements: its moments act at their ends only. Of `erls`, what is left at second"
        " order of the rotation.",
        rows,
        {"unloaded": unloaded},
    )


def draw(comparison: Comparison, figure: Figure) -> None:
    """Frequencies over those without load."""
    panel = figure.subplots()
    places = np.arange(len(comparison.rows))
    still = np.array(comparison.curves["unloaded"])
    panel.bar(places, [r.reference for r in comparison.rows] / still - 1.0, color="0.8", label="frame")
    for name, style in zip(FORMULATIONS, ("C0o", "C1x"), strict=True):
        values = [np.nan if r.found[name] is None else r.found[name] for r in comparison.rows]
        panel.plot(places, np.array(values) / still - 1.0, style, label=name)
    panel.set_yscale("symlog", linthresh=0.1)
    panel.set_xticks(
        places, [r.quantity.split(":")[0] for r in comparison.rows], rotation=75, fontsize=6, ha="right"
    )
    panel.set_ylabel("change of the frequency by its load")
    panel.legend(fontsize=8)
