"""What an hour of standard fire costs, model by model.

    python benchmarks/door_speed.py [--json] [--smoke]

Processor time (user and system, of all threads) of `Heat.advance` over 3600 s with a stop each
60 s, the kernels compiled beforehand: the least of three runs. Error: the largest difference on
the unexposed face and the exposed middle from the same mesh with a hundredth of the tolerance.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from pathlib import Path
from typing import Any

import numpy as np

from thermal_node import Heat, door_model, load_scene

SCENE = Path(__file__).resolve().parents[1] / "config" / "thesis_door_calibrated.yaml"
MODELS: dict[str, tuple[dict[str, Any], float]] = {
    "column (3 layers, 14 bricks)": ({"solver.model": "column"}, 0.05),
    "column with rim": ({"solver.model": "column_rim"}, 0.5),
    "quarter, 20 x 40 x 14": ({}, 4.0),
    "quarter, finite elements": ({"mesh.discretisation": "finite_element"}, 4.0),
    "whole, 40 x 80 x 14": ({"mesh.symmetry": "none", "mesh.in_plane": [40, 80]}, 15.0),
}


def march(overrides: dict[str, Any], tolerance: float | None = None) -> tuple[Heat, Any, float]:
    """An hour's march: the state, the temperatures each minute, processor time in s."""
    if tolerance is not None:
        overrides = {**overrides, "solver.tolerance": tolerance}
    model = door_model(load_scene(SCENE, overrides))
    heat = Heat(model)
    kept = np.r_[0, np.arange(len(model.nodes) - model.mesh.unexposed_area.size, len(model.nodes))]
    field = []
    start = time.process_time()
    for minute in range(1, 61):
        if not (status := heat.advance(60.0 * minute)).ok:
            raise SystemExit(status.reason)
        field.append(heat.temperature[kept])
    return heat, np.array(field), time.process_time() - start


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON object")
    parser.add_argument("--smoke", action="store_true", help="the column and the strip only, once")
    arguments = parser.parse_args()
    chosen = dict(list(MODELS.items())[:2]) if arguments.smoke else MODELS
    march({"solver.model": "column"})
    rows = []
    for name, (overrides, target) in chosen.items():
        runs = [march(overrides) for _ in range(1 if arguments.smoke else 3)]
        heat, field, _ = runs[0]
        error = 0.0
        if not arguments.smoke:
            error = float(np.abs(field - march(overrides, 3e-4)[1]).max())
        rows.append(
            {
                "model": name,
                "unknowns": len(heat.temperature),
                "steps": heat.steps,
                "processor_s": min(run[2] for run in runs),
                "target_s": target,
                "time_error_k": error,
                "worst_heat_balance": heat.balance.worst,
            }
        )
    # getrusage would count what the process that started this one had
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text("ascii").splitlines())
    memory = int(status["VmHWM"].split()[0]) / 1024.0
    about = {"memory_mib": memory, "python": platform.python_version(), "numpy": np.__version__}
    if arguments.json:
        print(json.dumps({"rows": rows, **about}))
        return
    heads = ("unknowns", 9), ("steps", 7), ("CPU s", 9), ("target", 8), ("error K", 9)
    print(f"{'model':32}" + "".join(f"{h:>{w}}" for h, w in heads) + f"{'balance':>10}")
    for r in rows:
        print(
            f"{r['model']:32}{r['unknowns']:9d}{r['steps']:7d}{r['processor_s']:9.3f}"
            f"{r['target_s']:8.2f}{r['time_error_k']:9.3f}{r['worst_heat_balance']:10.1e}"
        )
    print(f"peak memory {memory:.0f} MiB; Python {about['python']}, NumPy {about['numpy']}")


if __name__ == "__main__":
    main()
