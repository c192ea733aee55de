"""What accuracy costs: error against processor time, by time step tolerance, mesh and model.

    python benchmarks/door_accuracy.py [--json]

The problem: the calibrated thesis door, an hour of ISO 834. Error: the largest difference, K, at
the middle of both faces and at 100 mm from the edge over the hour, sampled each minute, from a
reference on 30 x 60 x 44 bricks at a hundredth of the default tolerance. Processor time as in
door_speed.py.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

from thermal_node import load_scene, simulate

SCENE = Path(__file__).resolve().parents[1] / "config" / "thesis_door_calibrated.yaml"
NAMES = ("ftp_centre", "exposed_centre", "en_right_edge")
QUIET = {"deformation.model": "none"}
REFERENCE = {
    "mesh.in_plane": [30, 60],
    "mesh.layers": [2, 40, 2],
    "mesh.first_brick": 1.5e-3,
    "solver.tolerance": 3e-3,
}
VARIANTS: dict[str, dict[str, Any]] = {
    "default": {},
    "tolerance 0.3": {"solver.tolerance": 0.3},
    "tolerance 0.003": {"solver.tolerance": 0.003},
    "sdirk2, 10 s": {"solver.method": "sdirk2", "solver.step": 10.0},
    "implicit Euler, 10 s": {"solver.method": "implicit_euler", "solver.step": 10.0},
    "implicit Euler, 60 s": {"solver.method": "implicit_euler", "solver.step": 60.0},
    "10 x 20 x 14": {"mesh.in_plane": [10, 20]},
    "20 x 40 x 8": {"mesh.layers": [1, 6, 1]},
    "20 x 40 x 26": {"mesh.layers": [1, 24, 1]},
    "column with rim": {"solver.model": "column_rim"},
    "column": {"solver.model": "column"},
}


def burn(overrides: dict[str, Any]) -> tuple[np.ndarray, float]:
    """Readings (3, 61), °C, and processor time, s."""
    scene = load_scene(SCENE, {**QUIET, **overrides})
    start = time.process_time()
    run = simulate(scene)
    return np.array([run.probes[name] for name in NAMES]), time.process_time() - start


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON object")
    arguments = parser.parse_args()
    burn({"solver.model": "column"})
    reference, _ = burn(REFERENCE)
    rows = []
    for name, overrides in VARIANTS.items():
        found, seconds = burn(overrides)
        error = np.abs(found - reference).max(axis=1)
        rows.append({"variant": name, "processor_s": seconds, **dict(zip(NAMES, error, strict=True))})
    if arguments.json:
        print(json.dumps(rows))
        return
    print(f"{'variant':24}{'CPU s':>8}" + "".join(f"{n:>17}" for n in NAMES))
    for r in rows:
        print(f"{r['variant']:24}{r['processor_s']:8.2f}" + "".join(f"{r[n]:17.2f}" for n in NAMES))


if __name__ == "__main__":
    main()
