"""The thesis' door beside CalculiX, in one run: processor time and error.

    apt-get install calculix-ccx
    python benchmarks/peers_door.py [--quarter] [--json FILE]

The strip from the leaf's middle to its upright edge, an hour of ISO 834 on the same mesh. Error: the
largest difference in K, at five places each minute, from CalculiX on a finer mesh without error of its
steps (tests/thermal/data/door_strip_calculix.csv). With --quarter the quarter leaf, against the same
places at mid-height, both on one mesh, in plane 20 x 8 bricks in place of the scene's 20 x 40, so that
CalculiX takes minutes rather than hours. Its steps are implicit Euler's, whose error falls as the step does.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from peers import calculix

from thermal_node import door_model, load_scene, simulate
from thermal_node.model.door_model import DoorModel

ROOT = Path(__file__).resolve().parents[1]
SCENE = ROOT / "config" / "thesis_door_calibrated.yaml"
TABLE = ROOT / "tests" / "thermal" / "data" / "door_strip_calculix.csv"
QUIET = {"deformation.model": "none"}
QUARTER = {"solver.model": "full", "mesh.in_plane": [20, 8]}
STRIP = {"solver.model": "column_rim"}


def places(model: DoorModel, temperature: np.ndarray) -> dict[str, np.ndarray]:
    """Temperatures (K,) at the table's places, from fields (K, N)."""
    nz = model.mesh.shape[0]
    field = temperature.reshape(len(temperature), *model.mesh.shape)[:, :, 0]
    return {
        "hot_c": field[:, 0, 0],
        "cold_c": field[:, -1, 0],
        "side_edge": field[:, -1, -1],
        "side_mid": field[:, nz // 2, -1],
        "hot_side": field[:, 0, -1],
    }


def worst(found: dict[str, np.ndarray], right: dict[str, np.ndarray]) -> float:
    """The largest difference, K."""
    return float(max(np.abs(found[name] - right[name]).max() for name in found))


def main() -> None:
    """Print the table, or write one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quarter", action="store_true")
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    if not calculix.available():
        raise SystemExit("CalculiX is not installed: apt-get install calculix-ccx")
    with TABLE.open() as file:
        table = list(csv.DictReader(file))
    right = {name: np.array([float(row[name]) for row in table]) for name in table[0] if name != "t_s"}
    scene = load_scene(SCENE, {**QUIET, **(QUARTER if arguments.quarter else STRIP)})
    model = door_model(scene)
    simulate(scene, 60.0)  # compiles
    rows: list[dict[str, Any]] = []
    seconds = []
    for _ in range(3):
        begun = time.process_time()
        run = simulate(scene)
        seconds.append(time.process_time() - begun)
    error = worst(places(run.model, run.temperature[1:]), right)
    rows.append(
        {"tool": "flexsim", "steps": "adaptive", "error": error, "seconds": float(np.median(seconds))}
    )
    print(f"{'':10}{'steps':>10}{'error, K':>10}{'CPU s':>9}{'ratio':>8}")
    keep(rows, arguments)
    solid = model
    if not arguments.quarter:  # one brick thick, for a program that knows bricks only
        solid = replace(model, mesh=replace(model.mesh, y=np.array([0.0, 0.05])))
    for step in (10.0, 1.5) if arguments.quarter else (10.0, 5.0, 2.0):
        found = calculix.burn(solid, step)
        rows.append(
            {"tool": "CalculiX", "steps": f"{step:g} s", "seconds": found.cpu,
             "error": worst(places(solid, found.temperature[-len(table):]), right)}
        )  # fmt: skip
        keep(rows, arguments)


def keep(rows: list[dict[str, Any]], arguments: argparse.Namespace) -> None:
    """Print the last row, and write all of them."""
    row = rows[-1]
    row["ratio"] = row["seconds"] / rows[0]["seconds"]
    print(
        f"{row['tool']:10}{row['steps']:>10}{row['error']:10.2f}{row['seconds']:9.2f}{row['ratio']:8.0f}",
        flush=True,
    )
    if arguments.json:
        kept = {
            "problem": "quarter" if arguments.quarter else "strip",
            "load": os.getloadavg()[0],
            "rows": rows,
        }
        Path(arguments.json).write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
