"""What studies promise of random robots holds: against references far finer than their own."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flexsim.study.choice import Cost, choose, truth_of
from flexsim.study.robot import RobotStudy
from ruamel.yaml import YAML

NIGHTLY = 100


def random_robot(random: np.random.Generator) -> dict[str, Any]:
    """One or two links, stiff or soft, with springs, payloads, branches, jumps of torque and faults."""
    links: list[dict[str, Any]] = []
    for n in range(int(random.integers(1, 3))):
        joint: dict[str, Any] = {"name": f"j{n}", "viscous_friction": float(random.choice([0.0, 0.05]))}
        if random.random() < 0.2:
            joint |= {
                "stiffness": float(10.0 ** random.uniform(2.5, 4.0)),
                "rotor_inertia": 0.02,
                "damping": 0.5,
            }
        side = float(10.0 ** random.uniform(-2.2, -1.5))
        link: dict[str, Any] = {
            "name": f"l{n}",
            "dh": {"a": float(random.uniform(0.2, 0.7))},
            "joint": joint,
            "beam": {
                "width": side,
                "depth": 1.3 * side,
                "density": 2700.0,
                "youngs_modulus": 7e10,
                "elements": 2,
            },
            "flexible": bool(random.random() < 0.8),
        }
        if random.random() < 0.5:
            link["payload"] = {"mass": float(random.uniform(0.1, 1.0))}
        if n and random.random() < 0.2:
            link["parent"] = "base"
        links.append(link)
    torque = []
    for n in range(len(links)):
        size = float(10.0 ** random.uniform(-1.0, 0.7))
        kind = str(random.choice(["constant", "sine", "table", "none"]))
        entry: dict[str, Any] = {"joint": f"j{n}", "type": kind, "start": float(random.uniform(0.0, 0.05))}
        if kind == "constant":
            entry |= {"amplitude": size, "end": entry["start"] + float(random.uniform(0.001, 0.05))}
        elif kind == "sine":
            entry |= {"amplitude": size, "frequency": float(random.uniform(1.0, 8.0)), "phase": 1.0}
        elif kind == "table":
            entry |= {"time": [0.0, 0.0311, 0.0707], "value": [0.0, size, 0.0]}
        if kind != "none":
            torque.append(entry)
    faults = []
    if random.random() < 0.2:
        faults.append({"kind": "disturbance", "value": 0.5, "start": 0.0237, "end": 0.0519})
    return {
        "model": "robot",
        "name": "random",
        "gravity": [0.0, float(random.choice([0.0, -9.81])), 0.0],
        "damping": {"alpha": 0.1, "beta": float(10.0 ** random.uniform(-4.5, -3.0))},
        "links": links,
        "initial": {"shape": "static"} if random.random() < 0.5 else {},
        "torque": torque,
        "faults": faults,
    }


def held(seed: int, folder: Path) -> tuple[bool, bool, str]:
    """Whether the reference is within its bound, and the true error of the advice within its promise."""
    random = np.random.default_rng([17, seed])
    path = folder / f"{seed}.yaml"
    YAML(typ="safe", pure=True).dump(random_robot(random), path)
    duration = float(random.choice([0.08, 0.12]))
    try:
        study = RobotStudy(str(path), {}, duration, {}, {}, quick=True)
        reference = study.reference(lambda words: None)
        finer = RobotStudy(str(path), {}, duration, {}, {}, quick=True, finer=2).reference(lambda words: None)
    except (ValueError, ArithmeticError) as problem:
        return True, True, f"not studied: {problem}"
    bound = reference.error["tip"]
    off = float(np.max(np.linalg.norm(reference.arrays["tip"] - finer.arrays["tip"], axis=-1)))
    own = [p for p in study.points() if p.curve.startswith(("rosenbrock_w", "generalized_alpha"))]
    outcomes = [study.measure(p, reference) for p in own if "modes" not in p.curve]
    measure = study.measures[0]
    truth = truth_of(study.scene.formulation, reference, "co_moving", False)
    tolerance = float(10.0 ** random.uniform(-6.0, -3.0))
    choice = choose(outcomes, measure, Cost(1000.0), None, tolerance, 10.0 * bound, truth)
    kept = True
    if choice.outcome is not None:
        scene = study.scene_with(choice.outcome.overrides)
        true = study.errors(study.move(scene), scene, finer)["tip"]
        assert true is not None
        kept = true <= choice.promise
    return math.isinf(bound) or off <= bound, kept, f"off {off:.3g} of {bound:.3g}; {choice.sentence}"


def test_two_random_studies(tmp_path: Path) -> None:
    for seed in range(2):
        reference, promise, said = held(seed, tmp_path)
        assert reference and promise, (seed, said)


@pytest.mark.nightly
def test_a_hundred_random_studies(tmp_path: Path) -> None:
    """Within the stated reference's error always, within the promise in 99 of 100."""
    found = [(seed, *held(seed, tmp_path)) for seed in range(NIGHTLY)]
    studied = [row for row in found if not row[3].startswith("not studied")]
    assert len(studied) > 0.8 * NIGHTLY
    assert all(reference for _, reference, _, _ in studied), [r for r in studied if not r[1]]
    broken = [r for r in studied if not r[2]]
    assert len(broken) <= 0.01 * NIGHTLY, broken
