"""The thesis' two robots beside Exudyn and MuJoCo, in one run: time at matched tip error.

    pip install exudyn mujoco           # the optional extra: pip install -e '.[peers]'
    python benchmarks/peers_robot.py [--json FILE] [--repeats 3] [--only falling|driven]

Error: the largest distance of the tip from the reference motion (tests/robot/data: geometrically exact
or ANCF beams of Exudyn, converged to about 0.01 mm), sampled each 10 ms. Time: processor time for a
simulated second; ours is the median step times the steps. Everything is undamped. A peer that is not
installed is left out and named.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from peers import exudyn_robot, mujoco_robot
from peers.exudyn_robot import Attempt
from peers.problem import YOUNG, Problem, driven, falling

from flexsim_node import load_scene, simulate


def scene(problem: Problem) -> dict[str, Any]:
    """The problem as a scene of ours."""
    links = []
    for number, link in enumerate(problem.links):
        upright = link.direction[2] == 1
        dh = {"d": link.length, "alpha": 0.5 * np.pi} if upright else {"a": link.length}
        beam = {
            "width": link.side_y,
            "depth": link.side_z,
            "density": problem.density,
            "youngs_modulus": YOUNG,
            "poissons_ratio": problem.poisson,
        }
        links.append({"name": f"link_{number + 1}", "dh": dh, "beam": beam})
    return {
        "model": "robot",
        "name": problem.name,
        "gravity": list(problem.gravity),
        "links": links,
        "effects": {"rotary_inertia": problem.section_inertia},
    }


def ours(problem: Problem, method: str, elements: int, step: float, repeats: int) -> Attempt:
    """Simulate the problem with flexsim."""
    overrides: dict[str, Any] = {"solver.method": method, "solver.step": step}
    overrides |= {f"links.{k}.beam.elements": elements for k in range(len(problem.links))}
    made = load_scene(scene(problem), overrides)

    def torque(t: float) -> np.ndarray:
        out = np.zeros(len(problem.links))
        out[0] = problem.torque * np.sin(2.0 * np.pi * t)
        return out

    simulate(made, duration=0.0)
    drive = torque if problem.torque else None
    seconds, tip = [], np.zeros((0, 3))
    for _ in range(repeats):
        run = simulate(made, drive, problem.duration, sample_period=problem.period)
        seconds.append(float(np.median(run.step_time)) * len(run.step_time) / problem.duration)
        tip = run.link_end[:, -1]
    return Attempt(seconds, tip)


def attempts(problem: Problem, repeats: int) -> Iterator[tuple[str, str, int, float, Attempt]]:
    """Tool, method, elements or springs a link, step, and what it came to."""
    planar = all(axis == (0, 0, 1) for axis in problem.axes)
    for method in ("rosenbrock_w", "generalized_alpha"):
        for elements in (1, 2, 4):
            for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
                attempt = ours(problem, method, elements, step, repeats)
                yield "flexsim", method, elements, step, attempt
    if installed("exudyn"):
        peer = exudyn_robot.planar_ancf if planar else exudyn_robot.spatial_exact
        name = "planar ANCF cable" if planar else "geometrically exact"
        for elements in (2, 4):
            for step in (2e-3, 1e-3, 5e-4, 2.5e-4) if planar else (2e-3, 1e-3):
                yield "Exudyn", name, elements, step, peer(problem, elements, step, repeats)
    if installed("mujoco"):
        for integrator, springs, step in (
            ("implicitfast", 2, 2.5e-4), ("implicitfast", 4, 1e-4), ("implicitfast", 4, 5e-5),
            ("RK4", 2, 5e-4), ("RK4", 2, 2.5e-4), ("RK4", 4, 2e-4), ("RK4", 4, 1e-4),
        ):  # fmt: skip
            attempt = mujoco_robot.attempt(problem, springs, step, integrator, planar, repeats)
            yield "MuJoCo", f"chain, {integrator}", springs, step, attempt


def installed(package: str) -> bool:
    """Whether a peer is there."""
    try:
        version(package)
    except PackageNotFoundError:
        return False
    return True


def matched(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each peer's time over ours at the smallest error that both reach."""
    found = []
    for tool in dict.fromkeys(r["tool"] + ", " + r["method"] for r in rows if r["tool"] != "flexsim"):
        mine = [r for r in rows if r["tool"] == "flexsim"]
        theirs = [r for r in rows if r["tool"] + ", " + r["method"] == tool]
        if not any(np.isfinite(r["error"]) for r in theirs):
            continue
        error = max(min(r["error"] for r in mine), min(r["error"] for r in theirs))
        best = [
            min((r for r in rows if r["error"] <= error * 1.0001), key=lambda r: r["seconds"])
            for rows in (mine, theirs)
        ]
        found.append(
            {"peer": tool, "error": error, "ours": best[0], "theirs": best[1],
             "ratio": best[1]["seconds"] / best[0]["seconds"]}
        )  # fmt: skip
    return found


def main() -> None:
    """Print the tables, or write one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", choices=("falling", "driven"))
    arguments = parser.parse_args()
    problems = [falling] if arguments.only != "driven" else []
    problems += [driven] if arguments.only != "falling" else []
    missing = [name for name in ("exudyn", "mujoco") if not installed(name)]
    result: dict[str, Any] = {
        "machine": {"processor": platform.processor() or platform.machine(),
                    "cores": len(os.sched_getaffinity(0)), "load": os.getloadavg()[0]},
        "versions": {n: version(n) for n in ("numpy", "numba", "exudyn", "mujoco") if installed(n)},
        "missing": missing,
        "problems": {},
    }  # fmt: skip
    for make in problems:
        problem = make()
        rows = []
        print(f"{problem.name}\n{'':10}{'method':22}{'elements':>9}{'step, ms':>10}{'tip, mm':>10}"
              f"{'s per s':>10}{'spread':>8}")  # fmt: skip
        for tool, method, elements, step, attempt in attempts(problem, arguments.repeats):
            error = problem.error(attempt.tip)
            # A robot that is half a metre off has fallen apart.
            error = error if error < 0.5 else float("inf")
            median = float(np.median(attempt.seconds)) if attempt.seconds else float("nan")
            spread = (max(attempt.seconds) - min(attempt.seconds)) / (2 * median) if attempt.seconds else 0.0
            rows.append({"tool": tool, "method": method, "elements": elements, "step": step,
                         "error": error, "seconds": median, "spread": spread})  # fmt: skip
            said = f"{error * 1e3:10.4f}" if np.isfinite(error) else f"{'unstable':>10}"
            print(
                f"{tool:10}{method:22}{elements:9}{step * 1e3:10.3f}{said}{median:10.4f}{spread:8.0%}",
                flush=True,
            )
        found = matched(rows)
        for m in found:
            print(
                f"at {m['error'] * 1e3:.3g} mm: {m['peer']} takes {m['ratio']:.2g} times as long"
                f" ({m['theirs']['seconds']:.3g} against {m['ours']['seconds']:.3g} s per s)"
            )
        for row in rows:
            row["error"] = row["error"] if np.isfinite(row["error"]) else None
        result["problems"][problem.name] = {"rows": rows, "matched": found}
        print()
    if missing:
        print(f"not installed, left out: {', '.join(missing)}")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
