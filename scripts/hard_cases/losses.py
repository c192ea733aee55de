"""Hard losses: friction that must stop a joint, damping that must only take."""

from __future__ import annotations

from itertools import product

import numpy as np

from flexsim_node import Run, SceneError, load_scene, natural_frequencies, simulate

from .case import Case, Outcome, Scene, bar, finite, planar

STILL = [0.0, 0.0, 0.0]


def braked(friction: float, inertia: float, step: float, speed: float, start: float) -> Run:
    """A rigid link that turns and is braked by Coulomb friction alone, seventy steps."""
    body = {"mass": 1e-9, "inertia": (inertia * np.eye(3)).tolist()}
    joint = {"coulomb_friction": friction, "coulomb_speed": speed}
    scene = planar(
        {"name": "link", "dh": {"a": 0.2}, "joint": joint, "rigid": body},
        gravity=STILL,
        initial={"velocity": [start]},
        solver={"step": step},
    )
    return simulate(load_scene(scene), duration=70 * step)


def coulomb_decades() -> Outcome:
    """J w' = -F tanh(w / c): sinh(w / c) falls as exp(-F t / (J c))."""
    worst, back, ended = 0.0, 0.0, "ok"
    for friction, inertia, step, speed in product((1e-2, 1.0, 1e2), (1e-4, 1.0), (1e-4, 1e-2), (1e-4, 1e-1)):
        start = 10.0 * friction * step / inertia  # it takes ten steps to stop
        run = braked(friction, inertia, step, speed, start)
        if run.status != "ok" or not finite(run):
            return Outcome(False, run.status)
        fall = start / speed - friction * 70 * step / (inertia * speed)
        # of small arguments sinh is the argument, of large ones the exponential
        right = speed * np.arcsinh(np.sinh(min(start / speed, 1.0)) * np.exp(fall - start / speed))
        if start / speed > 1.0:
            right = speed * np.arcsinh(0.5 * np.exp(min(fall, 700.0)))
        rate = run.joint_velocity[:, 0]
        worst = max(worst, (abs(float(rate[-1])) - float(right)) / start)
        back = max(back, -float(np.min(rate)) / speed)
    return Outcome(
        worst < 1e-3 and back < 0.25, ended, {"rate left, share": worst, "turned back, coulomb_speeds": back}
    )


def damped(zeroed: str, alpha: float) -> Run:
    scene = planar(
        bar("link_1", 0.5),
        bar("link_2", 0.5),
        damping={"alpha": alpha, "beta": 0.0},
        erls={"zeroed": zeroed},
        solver={"step": 2e-4},
    )
    return simulate(load_scene(scene), duration=0.6, sample_period=2e-3)


def risen(run: Run) -> float:
    return float(np.max(run.energy - np.minimum.accumulate(run.energy)))


def alpha_takes() -> Outcome:
    """The integrator's own rise is that without damping."""
    figures = {z: (risen(damped(z, 0.0)), risen(damped(z, 2.0))) for z in ("root", "chord")}
    return Outcome(
        all(rise <= 2.0 * own + 1e-8 for own, rise in figures.values()),
        "ok",
        {f"{z}, risen, J": rise for z, (_, rise) in figures.items()},
    )


def alpha_alike() -> Outcome:
    root, chord = damped("root", 2.0), damped("chord", 2.0)
    squared = max(run.validity["elastic_rotation"] for run in (root, chord)) ** 2
    apart = float(np.max(np.abs(root.link_end - chord.link_end)))
    return Outcome(
        apart < 10.0 * squared and root.status == chord.status == "ok",
        root.status,
        {"apart, m": apart, "squared elastic rotation": squared},
    )


def spring_on_fixed() -> Outcome:
    """A spring that is ignored would leave the frequency where it is."""

    def first(**joint: float) -> float:
        links: list[Scene] = [bar("arm", 0.5), bar("tool", 0.3, joint={"type": "fixed", **joint})]
        return float(natural_frequencies(load_scene(planar(*links)), [0.0])[0])

    stiff = first()
    try:
        soft = first(stiffness=5.0)
    except SceneError as refused:
        return Outcome("stiffness" in str(refused), f"refused: {refused}")
    return Outcome(soft < 0.9 * stiff, "ok", {"frequency, Hz": soft, "without, Hz": stiff})


CASES = [
    Case(
        "coulomb_over_decades",
        "friction, inertia, step and coulomb_speed over decades: up to 1e5 times what one step can follow",
        "comes to rest as J w' = -F tanh(w/c) does, to 1e-3 of the start; turns back by less than c/4",
        coulomb_decades,
    ),
    Case(
        "alpha_only_takes",
        "mass damping on elastic velocities while the links fall",
        "energy rises by no more than twice what the integrator gives without it",
        alpha_takes,
    ),
    Case(
        "alpha_whatever_is_zeroed",
        "mass damping on the velocity from rigid links, which are chosen freely",
        "root and chord part by less than ten times the squared elastic rotation",
        alpha_alike,
    ),
    Case(
        "spring_on_fixed_joint",
        "a fixed joint with a stiffness: a wish that can be overlooked",
        "refused by name, or the spring counts",
        spring_on_fixed,
    ),
]
