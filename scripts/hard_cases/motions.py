"""Hard motions: speeds, torques and starts that robots should not be given."""

from __future__ import annotations

import numpy as np

from flexsim_node import load_scene, simulate
from flexsim_node.motion.simulation import Simulation

from .case import Case, Outcome, arm, balanced, bar, bounded, close, finite, planar, stopped

STILL = [0.0, 0.0, 0.0]


def spin(rate, rise):
    """Prescribed motion: up to `rate` (rad/s) within `rise` s, smoothly."""

    def motion(t):
        s = min(t / rise, 1.0)
        w = 2 * np.pi
        angle = rate * rise * (s**2 / 2 + (np.cos(w * s) - 1) / w**2) + rate * max(t - rise, 0.0)
        return angle, rate * (s - np.sin(w * s) / w), rate / rise * (1 - np.cos(w * s)) if t < rise else 0.0

    return motion


def spinning_beam(**keys):
    return planar(
        bar("beam", 2.0, beam={"width": 0.01, "depth": 0.01, "elements": 8}, joint={"name": "hub"}),
        gravity=STILL,
        **keys,
    )


BENDING = 3.516 * np.sqrt(2e11 * 0.01**2 / 12 / 7800.0) / 2.0**2  # rad/s, the beam's first


def above_bending() -> Outcome:
    run = simulate(
        load_scene(spinning_beam()),
        duration=6.0,
        sample_period=0.05,
        prescribed={"hub": spin(2 * BENDING, 4.0)},
    )
    late = float(np.max(np.abs(run.node_displacement[run.time > 4.5, -1, 1])))
    return Outcome(
        run.status == "ok" and finite(run) and late < 0.02, run.status, {"late deflection, m": late}
    )


def above_bending_unstiffened() -> Outcome:
    scene = spinning_beam(effects={"centrifugal": False})
    run = simulate(
        load_scene(scene), duration=6.0, sample_period=0.05, prescribed={"hub": spin(2 * BENDING, 4.0)}
    )
    return stopped(run, "spin over the first bending frequency")


def hundred_turns() -> Outcome:
    """A spinning rod stretches by rho omega^2 L^3 / (3 E)."""
    rate, length = 200.0 * np.pi, 0.2
    scene = planar(
        bar("rod", length, joint={"name": "hub"}),
        gravity=STILL,
        damping={"alpha": 0.0, "beta": 1e-3},
        solver={"step": 1e-4},
    )
    run = simulate(load_scene(scene), duration=0.4, sample_period=0.001, prescribed={"hub": spin(rate, 0.2)})
    found = float(np.mean(run.node_displacement[-50:, -1, 0]))
    return close(run, found, 7800.0 * rate**2 * length**3 / (3 * 2e11), 0.02, "stretch, m")


def reversing_torque() -> Outcome:
    table = 5.0 * np.where(np.arange(1000) % 2 == 0, 1.0, -1.0)[:, None] * np.ones(3)
    scene = arm(gravity=STILL, damping={"alpha": 0.0, "beta": 2e-4})
    return bounded(simulate(load_scene(scene), table, 1.0, 1e-3), 1.5)


def torque_step() -> Outcome:
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5))
    run = simulate(load_scene(scene), lambda t: np.array([2e4 if t > 0.01 else 2.0, 0.0]), 0.1, 1e-3)
    return stopped(run, "elastic rotation", "converge", "beyond all bounds")


def impulse() -> Outcome:
    table = np.zeros((300, 2))
    table[10] = [200.0, -100.0]
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5), gravity=STILL)
    run = simulate(load_scene(scene), table, 0.3, 1e-3)
    after = run.energy[12:]
    risen = float(np.max(after - np.minimum.accumulate(after)) / after[0])
    kept = float(after[-1] / after[0])
    return Outcome(
        run.status == "ok" and finite(run) and risen < 1e-3,
        run.status,
        {"energy risen after it, share": risen, "energy kept, share": kept},
    )


def folded() -> Outcome:
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5), initial={"position": [0.0, np.pi]})
    return balanced(scene, simulate(load_scene(scene), duration=0.5, sample_period=0.01), 1e-3)


def stretched() -> Outcome:
    scene = planar(
        bar("link_1", 0.5),
        bar("link_2", 0.5),
        initial={"position": [-0.5 * np.pi, 0.0], "velocity": [8.0, 0.0]},
    )
    return balanced(scene, simulate(load_scene(scene), duration=1.0, sample_period=0.01), 1e-3)


def far_from_equilibrium() -> Outcome:
    soft = {"youngs_modulus": 5e9}
    scene = planar(bar("link_1", 0.5, beam=soft), bar("link_2", 0.5, beam=soft))
    run = simulate(
        load_scene(scene, {"initial.shape": "undeformed"}),
        duration=0.5,
        sample_period=0.01,
        prescribed={"link_1_joint": lambda t: (0.0, 0.0, 0.0)},
    )
    return bounded(run, 1.0)


def reversed_gravity() -> Outcome:
    """The same robot goes on under the opposite weight."""
    links = bar("link_1", 0.5), bar("link_2", 0.5)
    down, up = (Simulation(load_scene(planar(*links, gravity=[0.0, g, 0.0]))) for g in (-9.81, 9.81))
    down.warm()
    for _ in range(250):
        if down.step():
            return Outcome(False, down.reason)
    up.x[:], up.v[:] = down.x, down.v
    up.prepare()
    start = up.energy().sum()
    moved = 0.0
    for _ in range(500):
        if up.step():
            return Outcome(False, up.reason)
        moved = max(moved, float(up.energy()[0]))
    change = float(abs(up.energy().sum() - start)) / moved
    return Outcome(change < 1e-3, up.reason, {"energy drift": change})


def wrist_singularity() -> Outcome:
    """A wrist whose first and last axis coincide: two joints for one direction."""
    body = {"mass": 0.2, "inertia": [[2e-4, 0.0, 0.0], [0.0, 2e-4, 0.0], [0.0, 0.0, 2e-4]]}
    quarter = 0.5 * np.pi
    scene = arm(gravity=STILL, damping={"alpha": 0.0, "beta": 2e-4})
    scene["links"] += [
        {"name": "roll", "dh": {"alpha": -quarter}, "rigid": body},
        {"name": "pitch", "dh": {"alpha": quarter}, "rigid": body},
        {"name": "tool", "dh": {"d": 0.1}, "rigid": body},
    ]
    torque = np.array([0.0, 0.0, 0.0, 0.01, 0.0, -0.01])
    return bounded(simulate(load_scene(scene), lambda t: torque * np.sin(20 * t), 0.5, 1e-3), 1.6)


CASES = [
    Case(
        "spin_above_bending",
        "a beam at twice its first bending frequency: without stiffening it bends by metres",
        "stays straight within 2 cm",
        above_bending,
    ),
    Case(
        "spin_above_bending_off",
        "the same without the effect centrifugal",
        "stops where the spin passes the frequency",
        above_bending_unstiffened,
    ),
    Case(
        "hundred_turns_a_second",
        "centrifugal forces of 4e5 m/s2",
        "the rod stretches by rho w^2 L^3/(3 E) to 2 %",
        hundred_turns,
    ),
    Case(
        "torque_reversal_every_step",
        "a controller that chatters at the step's frequency",
        "bounded",
        reversing_torque,
    ),
    Case(
        "torque_step_1e4", "ten thousand times the usual torque at once", "stops with the reason", torque_step
    ),
    Case(
        "impulse_of_one_sample",
        "all modes are struck at once",
        "bounded; energy never rises after it",
        impulse,
    ),
    Case("folded", "the second link lies on the first", "energy kept to 0.1 %", folded),
    Case("stretched", "through the stretched configuration at 8 rad/s", "energy kept to 0.1 %", stretched),
    Case(
        "start_far_from_equilibrium",
        "soft links let go undeformed under their weight",
        "bounded",
        far_from_equilibrium,
    ),
    Case(
        "gravity_reversed_in_flight",
        "a load that turns round at once",
        "energy kept to 0.1 % afterwards",
        reversed_gravity,
    ),
    Case(
        "wrist_at_its_singularity",
        "two axes coincide: two joints share one inertia",
        "bounded",
        wrist_singularity,
    ),
]
