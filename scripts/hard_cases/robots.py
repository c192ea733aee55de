"""Hard robots: extreme stiffness, slenderness, mass and damping, and steps that don't suit them."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexsim_node import Run, SceneError, load_scene, simulate
from flexsim_node.motion.simulation import Simulation

from .case import (
    Case,
    Outcome,
    Scene,
    arm,
    balanced,
    bar,
    bounded,
    finite,
    never_rising,
    planar,
    stopped,
)


def fall(scene: Scene, duration: float = 0.3, **overrides: Any) -> Run:
    """Let a robot fall."""
    return simulate(load_scene(scene, overrides), duration=duration, sample_period=0.01)


def spread_of_moduli() -> Outcome:
    scene = planar(
        bar("hardest", 0.3, beam={"youngs_modulus": 1e14}),
        bar("softest", 0.1, beam={"youngs_modulus": 1e6, "width": 0.05, "density": 1000.0}),
        bar("wood", 0.05, beam={"youngs_modulus": 1e10}),
    )
    run = fall(scene, 0.3)
    if run.status != "ok":
        return stopped(run, "elastic rotation")
    return balanced(scene, run, 1e-2)


def stubby() -> Outcome:
    scene = planar(*(bar(f"block_{k}", 0.05, beam={"width": 0.01}) for k in range(3)))
    return balanced(scene, fall(scene), 1e-3)


def whip() -> Outcome:
    scene = planar(bar("wire", 2.0, beam={"width": 0.001, "depth": 0.001, "elements": 8}))
    run = fall(scene, 1.0)
    return balanced(scene, run, 1e-2) if run.status == "ok" else stopped(run, "elastic rotation")


def gram_before_hundredweight() -> Outcome:
    light = {"density": 100.0, "width": 0.01, "depth": 0.01}
    scene = planar(
        bar("gram", 0.1, beam=light),
        bar("arm", 0.3, payload={"mass": 100.0}),
    )
    return balanced(scene, fall(scene), 1e-3)


def one_element() -> Outcome:
    scene = planar(*(bar(f"link_{k}", 0.5, beam={"elements": 1}) for k in range(2)))
    return balanced(scene, fall(scene, 1.0), 1e-4)


def many_elements() -> Outcome:
    scene = planar(bar("fine", 0.5, beam={"elements": 64}))
    return balanced(scene, fall(scene, 0.3), 1e-4)


def long_chain() -> Outcome:
    scene = planar(*(bar(f"link_{k}", 0.1, beam={"elements": 1}) for k in range(24)))
    return balanced(scene, fall(scene, 0.2), 1e-3)


def heavy_eccentric_payload() -> Outcome:
    body = {
        "mass": 20.0,
        "center_of_mass": [0.0, 0.2, 0.0],
        "inertia": [[0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]],
    }
    scene = planar(bar("link_1", 0.5, beam={"width": 0.03}), bar("link_2", 0.5, payload=body))
    return balanced(scene, fall(scene), 1e-2)


def overdamped() -> Outcome:
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5), damping={"alpha": 0.0, "beta": 1.0})
    return never_rising(scene, fall(scene), 1e-3)


def beta_against_the_step() -> Outcome:
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5), damping={"alpha": 0.0, "beta": 0.02})
    run, fine = fall(scene), fall(scene, **{"solver.step": 1e-4})
    apart = float(np.max(np.abs(run.link_end - fine.link_end)))
    return Outcome(
        run.status == "ok" and finite(run) and apart < 1e-3,
        run.status,
        {"against a tenth of the step, m": apart},
    )


def mass_damping() -> Outcome:
    scene = planar(bar("link_1", 0.5), damping={"alpha": 1e4, "beta": 0.0})
    return bounded(fall(scene), 0.5)


def step_of(h: float, steps: int) -> Outcome:
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5))
    loaded = load_scene(scene, {"solver.step": h})
    run = simulate(loaded, duration=steps * h, sample_period=h)
    if run.status != "ok":
        return stopped(run, "did not converge", "smaller step")
    return balanced(scene, run, 0.2 if h >= 1e-2 else 1e-3)


def explicit_on_steel() -> Outcome:
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5))
    explicit: dict[str, Any] = {"solver.method": "runge_kutta_4"}
    run = fall(scene, **explicit)
    return stopped(run, "beyond all bounds", "validity", "singular")


def million_steps() -> Outcome:
    """Undamped, an hour's worth of milliseconds."""
    scene = planar(bar("link", 0.5, beam={"elements": 1}))
    robot = Simulation(load_scene(scene))
    robot.warm()
    start = robot.energy().sum()
    height = 0.0
    for _ in range(100):
        for _ in range(10_000):
            if robot.step():
                return Outcome(False, robot.reason)
        height = max(height, float(abs(robot.energy()[0])))
    change = abs(robot.energy().sum() - start) / max(height, 1e-12)
    sound = bool(np.all(np.isfinite(robot.x)) and np.all(np.isfinite(robot.v)))
    return Outcome(sound and change < 0.05, robot.reason, {"energy drift": float(change)})


def stiff_joint_spring() -> Outcome:
    joint = {"rotor_inertia": 0.01, "stiffness": 1e9}
    scene = planar(bar("link_1", 0.5, joint=joint), bar("link_2", 0.5, joint=joint))
    return balanced(scene, fall(scene), 1e-3)


def sticking_joint() -> Outcome:
    joint = {"coulomb_friction": 50.0, "coulomb_speed": 1e-6}
    scene = planar(bar("link", 0.5, joint=joint))
    run = fall(scene, 0.5)
    crept = float(abs(run.joint_position[-1, 0]))
    return Outcome(run.status == "ok" and finite(run) and crept < 1e-3, run.status, {"crept, rad": crept})


def hardly_any_inertia() -> Outcome:
    scene = arm(initial={"position": [0.0, 0.5 * np.pi, 0.0]}, gravity=[0.0, 0.0, 0.0])
    run = simulate(load_scene(scene), lambda t: np.array([1e-3, 0.0, 0.0]), 0.1, 1e-3)
    if run.status != "ok":
        return stopped(run, "inertia", "did not converge")
    return bounded(run, 1.5)


def nearly_singular_zeroed() -> Outcome:
    """The x of a stretched arm's end does not move with its last joint."""
    zeroed = [{"link": "link_1", "node": 2, "dof": "y"}, {"link": "link_2", "node": 2, "dof": "x"}]
    scene = planar(bar("link_1", 0.5), bar("link_2", 0.5), erls={"zeroed": zeroed})
    try:
        load = load_scene(scene)
        run = simulate(load, duration=0.1, sample_period=0.01)
    except SceneError as refused:
        return Outcome("J_0 is singular" in str(refused), f"refused: {refused}")
    return stopped(run, "J_0")


def watchmaker() -> Outcome:
    """Links of 5 mm and a tenth of a millimetre of steel: milligrams."""
    beam = {"width": 1e-4, "depth": 3e-4}
    scene = planar(bar("link_1", 5e-3, beam=beam), bar("link_2", 5e-3, beam=beam))
    return balanced(scene, simulate(load_scene(scene), duration=0.02, sample_period=1e-3), 1e-3)


def crane() -> Outcome:
    """A jib of 40 m under its own weight."""
    beam = {"width": 0.6, "depth": 0.5, "density": 800.0}
    scene = planar(bar("jib", 40.0, beam=beam), bar("fly_jib", 10.0, beam=beam))
    return balanced(scene, fall(scene, 1.0), 1e-3)


CASES = [
    Case(
        "moduli_1e6_to_1e14",
        "eight decades of stiffness in one chain: round-off eats the softest link",
        "energy kept to 1 %, or a stop that names the rotation",
        spread_of_moduli,
    ),
    Case(
        "length_to_depth_5",
        "stubby links: bending as stiff as stretching, frequencies of 10 kHz and more",
        "energy kept to 0.1 %",
        stubby,
    ),
    Case(
        "length_to_depth_2000",
        "a wire that hangs rather than bends: linear rotations are wrong",
        "energy kept to 1 %, or a stop that names the elastic rotation",
        whip,
    ),
    Case(
        "gram_before_100_kg",
        "a mass ratio of 1e5: the light link follows the heavy one's constraint force",
        "energy kept to 0.1 %",
        gram_before_hundredweight,
    ),
    Case("one_element", "the coarsest mesh: a whole link is one cubic", "energy kept to 1e-4", one_element),
    Case(
        "sixty_four_elements",
        "elements of 8 mm: axial waves of 200 kHz at steps of 1 ms",
        "energy kept to 1e-4",
        many_elements,
    ),
    Case("twenty_four_links", "a long chain whips: its end turns fast", "energy kept to 0.1 %", long_chain),
    Case(
        "eccentric_payload",
        "20 kg beside the end: bending and turning couple strongly",
        "energy kept to 1 %",
        heavy_eccentric_payload,
    ),
    Case(
        "overdamped",
        "beta = 1 s: every mode is overdamped, by up to a factor of 1e4",
        "energy never rises",
        overdamped,
    ),
    Case(
        "beta_twenty_steps",
        "beta = 20 steps: damping forces change faster than the step",
        "within 1 mm of a tenth of the step",
        beta_against_the_step,
    ),
    Case("alpha_1e4", "mass damping whose time constant is a tenth of a step", "bounded", mass_damping),
    Case(
        "links_of_5_mm",
        "milligrams, and frequencies of kilohertz",
        "energy kept to 0.1 %",
        watchmaker,
    ),
    Case("jib_of_40_m", "tonnes, and seconds", "energy kept to 0.1 %", crane),
    Case(
        "step_2e-7",
        "hardly longer than the shortest step there is",
        "energy kept to 0.1 %",
        lambda: step_of(2e-7, 3000),
    ),
    Case(
        "step_1e-6",
        "round-off adds up over many tiny steps",
        "energy kept to 0.1 %",
        lambda: step_of(1e-6, 5000),
    ),
    Case("step_1e-5", "steps that resolve everything", "energy kept to 0.1 %", lambda: step_of(1e-5, 5000)),
    Case(
        "step_1e-4",
        "steps as long as the highest bending modes",
        "energy kept to 0.1 %",
        lambda: step_of(1e-4, 3000),
    ),
    Case(
        "step_1e-2",
        "a step in which the robot turns visibly",
        "energy kept to 20 %, or a stop that asks for a smaller step; 1e-3 holds",
        lambda: step_of(1e-2, 50),
    ),
    Case(
        "step_1e-1",
        "a step in which the robot falls half its height",
        "energy kept to 20 %, or a stop that asks for a smaller step; 1e-3 holds",
        lambda: step_of(1e-1, 10),
    ),
    Case(
        "explicit_on_steel",
        "classical Runge-Kutta at 1 ms needs steps below 4e-5 s here",
        "stops with the reason; 2e-5 holds",
        explicit_on_steel,
    ),
    Case(
        "million_steps", "1e6 steps without damping: any drift shows", "energy drift below 5 %", million_steps
    ),
    Case(
        "joint_spring_1e9",
        "a joint a thousand times stiffer than its link",
        "energy kept to 0.1 %",
        stiff_joint_spring,
    ),
    Case(
        "sticking_joint",
        "Coulomb friction that turns over within 1e-6 rad/s",
        "sticks: creeps below 1e-3 rad",
        sticking_joint,
    ),
    Case(
        "no_inertia_about_joint_1",
        "an upright arm: all its mass lies on the first joint's axis",
        "bounded, or a stop that names the inertia",
        hardly_any_inertia,
    ),
    Case(
        "zeroed_dofs_nearly_singular",
        "zeroed dofs that don't move with a joint: the rigid links are undefined",
        "refused, with J_0 as reason",
        nearly_singular_zeroed,
    ),
]
