"""Hard closed loops."""

from __future__ import annotations

import numpy as np

from flexsim_node import SceneError, load_scene, simulate

from .case import Case, Outcome, Scene, bar, finite


def parallelogram(**keys) -> Scene:
    """Four equal pairs: it folds flat, where two branches meet."""
    return {
        "model": "robot",
        "name": "parallelogram",
        "gravity": [0.0, 0.0, 0.0],
        "damping": {"alpha": 0.0, "beta": 1e-4},
        "links": [
            bar("crank", 0.2, joint={"name": "crank_joint"}),
            bar("coupler", 0.4, joint={"name": "coupler_joint", "actuated": False}),
            {"name": "ground", "parent": "base", "dh": {"a": 0.4}, "joint": {"type": "fixed"}},
            bar("rocker", 0.2, joint={"name": "rocker_joint", "actuated": False}),
        ],
        "loops": [{"links": ["coupler", "rocker"]}],
        **keys,
    }


def through_singular() -> Outcome:
    """Driven flat, where crank, coupler and rocker lie in one line."""
    start = {"crank_joint": 1.0, "coupler_joint": -1.0, "rocker_joint": 1.0}
    scene = load_scene(parallelogram(initial={"position": start}))
    motion = {"crank_joint": lambda t: (1.0 - t, -1.0, 0.0)}
    run = simulate(scene, duration=1.5, sample_period=0.005, prescribed=motion)
    warned = any("singular" in words for words in run.warnings) or "singular" in run.status
    gap = float(np.max(run.loop_gap))
    whole = run.status == "ok" or any(word in run.status for word in ("loop", "converge", "singular"))
    return Outcome(
        warned and whole and finite(run) and gap < 1e-9,
        run.status,
        {"largest gap, m": gap, "least conditioning": float(np.min(run.conditioning))},
    )


def out_of_reach() -> Outcome:
    scene = parallelogram()
    scene["links"][2]["dh"]["a"] = 1.0
    try:
        simulate(load_scene(scene), duration=0.01)
    except SceneError as refused:
        return Outcome("m" in str(refused), f"refused: {refused}")
    return Outcome(False, "was not refused")


CASES = [
    Case(
        "loop_through_singular",
        "a parallelogram driven flat: its rocker may go either way",
        "warned before; closed to 1e-9 m as long as it runs; ends whole or with the reason",
        through_singular,
    ),
    Case("loop_out_of_reach", "links too short to meet", "refused with the gap", out_of_reach),
]
