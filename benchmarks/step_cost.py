"""What a step of the robot costs, by scene, number of links, integrator and effect.

    python benchmarks/step_cost.py [--quick] [--json]

Two clocks: `call` is what a caller in Python waits for one step (as `run.step_time`), `loop` is the
mean inside a compiled loop of many steps (not with --quick: that loop is compiled anew).  Warm caches, one
thread; medians of several rounds, because other programs on the machine only ever add time.  Effects are
measured in turns within one run, as a ratio.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numba
import numpy as np

from flexsim_node import Scene, load_scene
from flexsim_node.integrators import METHODS
from flexsim_node.motion.simulation import Simulation
from flexsim_node.scene.schema import Effects

CONFIG = Path(__file__).parents[1] / "config"


def machine() -> dict[str, Any]:
    """What the figures were taken on."""
    cpu = platform.processor() or platform.machine()
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            cpu = line.split(":", 1)[1].strip()
            break
    return {
        "cpu": cpu,
        "cores": len(os.sched_getaffinity(0)),
        "load": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
        **{name: version(name) for name in ("flexsim", "numpy", "numba", "scipy")},
    }


def chain(links: int, spatial: bool, method: str = "rosenbrock_w") -> Scene:
    """A chain of equal steel links, two elements each, hanging still but for gravity askew."""
    beam = {
        "width": 0.02,
        "depth": 0.02,
        "density": 7800.0,
        "youngs_modulus": 2e11,
        "elements": 2,
    }
    dh = {"a": 0.2, "alpha": 1.5707963267948966 if spatial else 0.0}
    joint = {"viscous_friction": 5.0}
    return load_scene(
        {
            "model": "robot",
            "name": f"chain_{links}",
            "gravity": [1.0, -1.0, -0.5 if spatial else 0.0],
            "damping": {"alpha": 1.0, "beta": 1e-4},
            "links": [{"name": f"link_{k}", "dh": dh, "beam": beam, "joint": joint} for k in range(links)],
            "solver": {"method": method},
        }
    )


@numba.njit
def many(step, arrays, h, option, count):
    """Status of the first step that failed, or 0."""
    for _ in range(count):
        status = step(arrays, h, option)
        if status != 0:
            return status
    return 0


def fresh(scene: Scene) -> Simulation:
    """A robot whose kernels are compiled and whose memory holds the initial state."""
    robot = Simulation(scene)
    robot.prepare()
    robot.warm()
    return robot


def measure(scene: Scene, steps: int, rounds: int) -> dict[str, float]:
    """Median and 99th percentile of a call, and the mean in a compiled loop, microseconds."""
    robot = fresh(scene)
    times = np.zeros(steps)
    for k in range(steps):
        begin = time.perf_counter()
        status = robot.step()
        times[k] = time.perf_counter() - begin
        if status != 0:
            raise RuntimeError(f"{scene.name}: {robot.reason}")
    loops = [float(np.mean(times))] if rounds == 0 else []
    for n in range(rounds + 1 if rounds else 0):
        robot = fresh(scene)
        begin = time.perf_counter()
        status = many(
            METHODS[scene.solver.method].step,
            robot.arrays,
            robot.step_size,
            robot.option,
            steps,
        )
        if status != 0:
            raise RuntimeError(f"{scene.name}: status {status} in the compiled loop")
        if n > 0:  # the first compiles
            loops.append((time.perf_counter() - begin) / steps)
    return {
        "call_median_us": 1e6 * float(np.median(times)),
        "call_p99_us": 1e6 * float(np.percentile(times, 99)),
        "loop_us": 1e6 * float(np.median(loops)),
        "unknowns": robot.model.unknowns,
    }


def with_effect(name: str, on: bool) -> dict[str, Any]:
    """Overrides of the anthropomorphic scene that switch one effect, and give it something to do."""
    found: dict[str, Any] = {f"effects.{name}": on}
    if name == "joint_elasticity":
        for n in range(3):
            found[f"links.{n}.joint.rotor_inertia"] = 1e-3
            found[f"links.{n}.joint.stiffness"] = 1e4 if on else None
    if name == "joint_friction":
        found.update({f"links.{n}.joint.viscous_friction": 0.1 for n in range(3)})
    return found


def effects(steps: int, rounds: int) -> dict[str, dict[str, float]]:
    """Median cost of a step with each effect off and on, and with all on, against the scene as it is."""
    names = list(Effects.model_fields)
    everything = {key: value for name in names for key, value in with_effect(name, True).items()}
    cases = {"as the scene is": {}, "everything on": everything}
    for name in names:
        for on in (False, True):
            cases[f"{name} {'on' if on else 'off'}"] = with_effect(name, on)
    robots = {k: fresh(load_scene(CONFIG / "anthropomorphic.yaml", v)) for k, v in cases.items()}
    times: dict[str, list[float]] = {name: [] for name in robots}
    for _ in range(max(rounds, 1)):
        for name, robot in robots.items():
            robot.reset()
            for _ in range(steps):
                begin = time.perf_counter()
                status = robot.step()
                times[name].append(time.perf_counter() - begin)
                if status != 0:
                    raise RuntimeError(f"{name}: {robot.reason}")
    usual = float(np.median(times["as the scene is"]))
    return {
        name: {
            "call_median_us": 1e6 * float(np.median(row)),
            "ratio": float(np.median(row)) / usual,
            "unknowns": robots[name].model.unknowns,
        }
        for name, row in times.items()
    }


def memory() -> float:
    """Largest resident memory of this process so far, MB."""
    # getrusage would count what the process that started this one had
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text("ascii").splitlines())
    return int(status["VmHWM"].split()[0]) / 1024


def exponent(counts: list[int], costs: list[float]) -> float:
    """p of cost ~ links^p, least squares of the logarithms."""
    return float(np.polyfit(np.log(counts), np.log(costs), 1)[0])


def all_figures(quick: bool) -> dict[str, Any]:
    """Every figure, as one object for programs."""
    steps, rounds = (50, 0) if quick else (2000, 5)
    first = fresh(load_scene(CONFIG / "anthropomorphic.yaml"))
    for _ in range(steps):
        first.step()
    used = memory()  # before the compiler of the loops below takes its own
    small = {}
    for name in ("anthropomorphic", "planar_double_pendulum"):
        small[name] = measure(load_scene(CONFIG / f"{name}.yaml"), steps, rounds)
    counts = [2, 4] if quick else [2, 4, 8, 16, 32]
    chains: dict[str, Any] = {}
    for kind in ("planar", "spatial"):
        found = {n: measure(chain(n, kind == "spatial"), steps // 4, rounds) for n in counts}
        chains[kind] = {
            "links": found,
            "exponent": exponent(counts, [found[n]["loop_us"] for n in counts]),
        }
    methods = {}
    for method in ["rosenbrock_w"] if quick else METHODS:
        # an explicit method needs short steps here; the cost of one does not depend on its length
        step = 1e-6 if method == "runge_kutta_4" else 1e-3
        overrides = {"solver.method": method, "solver.step": step}
        methods[method] = measure(load_scene(CONFIG / "anthropomorphic.yaml", overrides), steps, rounds)
    return {
        "machine": machine(),
        "robots": small,
        "chains": chains,
        "methods": methods,
        "effects": effects(steps // 4, rounds),
        "memory_mb": used,
    }


def row(name: str, found: dict[str, float]) -> str:
    figures = (found[key] for key in ("call_median_us", "call_p99_us", "loop_us"))
    return f"  {name:28}{found['unknowns']:9d}" + "".join(f"{x:11.1f}" for x in figures)


def print_table(found: dict[str, Any]) -> None:
    """The figures for people."""
    print(", ".join(f"{key} {value}" for key, value in found["machine"].items()))
    head = f"\n  {'microseconds a step':28}{'unknowns':>9}{'call p50':>11}{'call p99':>11}{'loop':>11}"
    print(head)
    for name, figures in found["robots"].items():
        print(row(name, figures))
    for kind, part in found["chains"].items():
        print(head)
        for count, figures in part["links"].items():
            print(row(f"{kind} chain, {count} links", figures))
        print(f"  cost grows as links^{part['exponent']:.2f}")
    print(head)
    for name, figures in found["methods"].items():
        print(row(f"anthropomorphic, {name}", figures))
    print(f"\n  {'anthropomorphic':28}{'unknowns':>9}{'call p50':>11}{'ratio':>11}")
    for name, figures in found["effects"].items():
        cost, ratio = figures["call_median_us"], figures["ratio"]
        print(f"  {name:28}{figures['unknowns']:9d}{cost:11.1f}{ratio:11.2f}")
    print(f"\n  memory of a simulation: {found['memory_mb']:.0f} MB")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a smoke run: figures mean nothing")
    parser.add_argument("--json", action="store_true", help="one object for programs")
    arguments = parser.parse_args()
    found = all_figures(arguments.quick)
    if arguments.json:
        json.dump(found, sys.stdout, indent=1)
    else:
        print_table(found)
    if not all(math.isfinite(x["loop_us"]) for x in found["robots"].values()):
        sys.exit(1)


if __name__ == "__main__":
    main()
