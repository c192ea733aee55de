"""Hard closed loops."""

from __future__ import annotations

import numpy as np

from flexsim_node import SceneError, load_scene, natural_frequencies, simulate

from .case import Case, Outcome, Scene, arm, balanced, bar, finite, planar


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


def beside_singular() -> Outcome:
    """Let go almost flat: the rocker must not jump to its other branch."""
    start = {"crank_joint": 0.03, "coupler_joint": -0.03, "rocker_joint": 0.03}
    scene = parallelogram(
        initial={"position": start}, gravity=[0.0, -9.81, 0.0], damping={"alpha": 0.0, "beta": 0.0}
    )
    run = simulate(load_scene(scene), duration=0.002, sample_period=1e-4)
    warned = any("singular" in words for words in run.warnings) or "singular" in run.status
    gap = float(np.max(run.loop_gap))
    turned = run.joint_position[:, 0] + run.joint_position[:, 1]
    return Outcome(
        warned and finite(run) and gap < 1e-9 and float(np.max(np.abs(turned))) < 0.03,
        run.status,
        {"largest gap, m": gap, "coupler turned, rad": float(np.max(np.abs(turned)))},
    )


def loop_falls() -> Outcome:
    """A parallelogram of unequal stiffness: a crank of steel, a rocker forty times softer."""
    start = {"crank_joint": 1.0, "coupler_joint": -1.0, "rocker_joint": 1.0}
    scene = parallelogram(
        initial={"position": start}, gravity=[0.0, -9.81, 0.0], damping={"alpha": 0.0, "beta": 0.0}
    )
    scene["links"][3]["beam"]["youngs_modulus"] = 5e9
    return balanced(scene, simulate(load_scene(scene), duration=0.2, sample_period=0.005), 1e-2)


def reduced_loop() -> Outcome:
    """Frequencies of the loop with every link reduced to six modes, against all of its elements."""
    start = {"crank_joint": 1.0, "coupler_joint": -1.0, "rocker_joint": 1.0}
    scene = parallelogram(initial={"position": start})
    for link in scene["links"]:
        if "beam" in link:
            link["beam"]["elements"] = 4
    full = natural_frequencies(load_scene(scene), [1.0])[:3]
    small = natural_frequencies(load_scene({**scene, "reduction": {"modes": 6}}), [1.0])[:3]
    off = float(np.max(np.abs(small / full - 1.0)))
    return Outcome(off < 1e-3, "ok", {"off": off, "first, Hz": float(small[0])})


def unequal_branches() -> Outcome:
    """A stiff arm and one that is twenty thousand times softer on one trunk."""
    scene = planar(
        bar("trunk", 0.4),
        bar("stiff", 0.3, beam={"youngs_modulus": 1e14}),
        bar("soft", 0.3, parent="trunk", beam={"youngs_modulus": 5e9}, joint={"name": "other"}),
    )
    return balanced(scene, simulate(load_scene(scene), duration=0.2, sample_period=0.005), 1e-2)


def wrists_in_a_row() -> Outcome:
    """Five links without length between two beams, each with a body and an axis of its own."""
    body = {"mass": 0.2, "inertia": [[2e-4, 0.0, 0.0], [0.0, 2e-4, 0.0], [0.0, 0.0, 2e-4]]}
    scene = arm(gravity=[0.0, 0.0, -9.81])
    wrists = [{"name": f"wrist_{k}", "dh": {"alpha": 1.1, "theta": 0.3}, "rigid": body} for k in range(5)]
    scene["links"] = [*scene["links"][:2], *wrists, scene["links"][2]]
    run = simulate(load_scene(scene), duration=0.2, sample_period=0.005)
    return balanced(scene, run, 1e-2)


CASES = [
    Case(
        "loop_through_singular",
        "a parallelogram driven flat: its rocker may go either way",
        "warned before; closed to 1e-9 m as long as it runs; ends whole or with the reason",
        through_singular,
    ),
    Case(
        "loop_beside_singular",
        "the parallelogram let go 0.03 rad from flat: both branches are near",
        "warned; closed to 1e-9 m; the coupler stays on its branch",
        beside_singular,
    ),
    Case(
        "loop_unequal_stiffness",
        "a loop falls whose rocker is forty times softer than its crank",
        "energy kept to 1 %",
        loop_falls,
    ),
    Case(
        "loop_of_reduced_links",
        "links reduced with their ends held, then joined to a loop",
        "three frequencies of all elements, to 0.1 %",
        reduced_loop,
    ),
    Case(
        "branches_1e14_and_5e9",
        "two arms on one trunk, one twenty thousand times softer",
        "energy kept to 1 %",
        unequal_branches,
    ),
    Case(
        "five_wrists_in_a_row",
        "links without length one after the other: joints share one point",
        "energy kept to 1 %",
        wrists_in_a_row,
    ),
    Case("loop_out_of_reach", "links too short to meet", "refused with the gap", out_of_reach),
]
