"""`formulation: auto`: the cheaper formulation that holds, measured, shown, and never a silent one."""

import numpy as np
import pytest
from scenes import link, robot

from flexsim_node import SceneError, linearize, load_scene, natural_frequencies, resolve_effects, simulate
from flexsim_node.analysis.decide import SHARE, decide
from flexsim_node.analysis.effects import Trial
from flexsim_node.analysis.formulations import DOUBLINGS, distance_of
from flexsim_node.analysis.step_cost import step_costs
from flexsim_node.model.model import build_model
from flexsim_node.model.tables import Tables
from flexsim_node.motion.simulation import Simulation
from flexsim_node.scene.schema import Undecided
from flexsim_node.scene.torque_profile import torque_profile
from flexsim_node.scene.variants import finer, in_formulation

SOFT, STIFF = 7e8, 2e11


def arm(modulus: float, tolerance: float = 2e-4, elements: int = 2, **keys):
    """Two links in a horizontal plane with a weight at the end, driven by sines."""
    beam = {"youngs_modulus": modulus, "elements": elements}
    torque = [
        {"joint": "j1", "type": "sine", "amplitude": 8.0, "frequency": 3.0},
        {"joint": "j2", "type": "sine", "amplitude": 2.0, "frequency": 4.0},
    ]
    payload = {"mass": 0.3, "center_of_mass": [0.0, 0.0, 0.0]}
    return load_scene(robot(
        link("l1", {"a": 0.5}, 0.02, 0.02, joint={"name": "j1"}, beam=beam),
        link("l2", {"a": 0.4}, 0.015, 0.015, joint={"name": "j2"}, beam=beam, payload=payload),
        **{"gravity": [0.0, 0.0, 0.0], "damping": {"beta": 5e-4}, "torque": torque, "duration": 0.1,
           "formulation": "auto", "tolerance": tolerance, **keys},
    ))  # fmt: skip


def truth(scene, drive, duration):
    """Tip of the scene in co-moving frames, everything on."""
    return simulate(in_formulation(scene, "co_moving"), drive, duration).link_end[:, -1]


def furthest(one, other):
    return float(np.max(np.linalg.norm(one - other, axis=1)))


def test_a_soft_arm_is_simulated_in_co_moving_frames():
    """Where the ERLS is off by more than the tolerance it isn't taken; a run of both says that it is off."""
    scene = arm(SOFT)
    decision = resolve_effects(scene)
    assert decision.scene.formulation == "co_moving"
    louder = torque_profile(scene)
    drive = lambda t: 2.0 * louder(t)  # noqa: E731
    off = furthest(
        simulate(in_formulation(scene, "erls"), drive, 0.2).link_end[:, -1], truth(scene, drive, 0.2)
    )
    assert off > SHARE * scene.tolerance
    apart = decision.chosen.apart
    assert apart.distance + apart.unsure > SHARE * scene.tolerance
    assert "formulation: co_moving; erls is" in decision.sentences()[0]
    assert decision.envelope is None  # nothing is left out


def test_a_stiff_arm_takes_the_cheaper_one():
    """Within the envelope the ERLS is no further from the truth than the decision says."""
    scene = arm(STIFF)
    decision = resolve_effects(scene)
    assert decision.scene.formulation == "erls"
    assert decision.chosen.off <= SHARE * scene.tolerance
    profile, random = torque_profile(scene), np.random.default_rng(7)
    for _ in range(3):
        scale, duration = random.uniform(0.3, 1.9), random.uniform(0.05, 0.19)
        drive = lambda t, s=scale: s * profile(t)  # noqa: E731
        run = simulate(scene, drive, duration)
        assert furthest(run.link_end[:, -1], truth(scene, drive, duration)) <= decision.chosen.off
        assert not [w for w in run.warnings if w.startswith("auto")]


def test_what_is_left_out_with_the_formulation_is_within_the_tolerance_too():
    """Effects may take what the formulation leaves of the tolerance: both together are within it."""
    scene = arm(STIFF, tolerance=2e-4, effects="auto")
    decision = resolve_effects(scene)
    assert decision.scene.formulation == "erls"
    assert decision.left_out
    assert decision.chosen.off + decision.together <= SHARE * scene.tolerance
    run = simulate(scene, duration=0.2)
    on = in_formulation(arm(STIFF), "co_moving").model_copy(
        update={"effects": Trial(decision.chosen.scene).scene.effects}
    )
    assert furthest(run.link_end[:, -1], simulate(on, duration=0.2).link_end[:, -1]) <= scene.tolerance
    soft = resolve_effects(arm(SOFT, effects="auto"))
    assert soft.scene.formulation == "co_moving"
    assert soft.scene.effects.coriolis is True and soft.scene.effects.centrifugal is True
    assert "bending_z" not in soft.left_out and "torsion" in soft.left_out


def test_everything_takes_the_same_formulation():
    """simulate, linear models and frequencies are the decided scene's, to the bit; a run says which."""
    for modulus in (SOFT, STIFF):
        scene = arm(modulus)
        decided = resolve_effects(scene).scene
        assert decide(scene)[0] == decided
        run, right = simulate(scene, duration=0.02), simulate(decided, duration=0.02)
        assert np.array_equal(run.link_end, right.link_end)
        assert run.decision.scene.formulation == decided.formulation
        robot_ = Simulation(decide(scene)[0])
        assert robot_.scene == decided  # which the node publishes
        assert load_scene(robot_.scene.model_dump()) == decided
        assert np.array_equal(linearize(scene, [0.2, 0.3]).A, linearize(decided, [0.2, 0.3]).A)
        assert np.array_equal(natural_frequencies(scene, [0, 0]), natural_frequencies(decided, [0, 0]))


def test_a_payload_that_comes_in_flight_changes_no_decision():
    """It is decided once, for all that the robot carries; other faults set in flight leave it so."""
    drop = [{"kind": "payload", "link": "l2", "mass": 0.1, "start": 0.02, "end": 0.04}]
    for modulus in (SOFT, STIFF):
        scene = arm(modulus, faults=drop)
        taken = resolve_effects(scene).scene.formulation
        flown = Simulation(decide(scene)[0])
        assert flown.scene.formulation == taken
        assert {model.scene.formulation for _, model in flown._plants} == {taken}
        flown.set_faults(arm(modulus))
        assert flown.model.scene.formulation == taken
        assert simulate(scene, duration=0.06).status == "ok"


def test_the_same_scene_gets_the_same_decision():
    """Made anew, with nothing kept, it is the same to the last digit."""
    from flexsim_node.analysis.decide import _resolved

    scene = arm(STIFF)
    first = resolve_effects(scene)
    _resolved.cache_clear()
    again = resolve_effects(scene)
    assert again is not first
    assert again.sentences() == first.sentences()
    assert again.scene == first.scene
    assert again.chosen.apart == first.chosen.apart


def test_an_undecided_formulation_reaches_no_kernel():
    scene = arm(STIFF)
    with pytest.raises(Undecided, match="formulation"):
        Tables(scene, True, ())
    with pytest.raises(Undecided, match="formulation"):
        build_model(scene)
    with pytest.raises(Undecided, match="formulation"):
        Simulation(scene)
    with pytest.raises(Undecided, match="decide it first"):
        Trial(scene)
    with pytest.raises(Undecided, match="formulation is auto"):
        _ = scene.co_moving


def test_who_leaves_the_envelope_is_warned_of_the_formulation():
    """Decided gently and then driven in earnest: the run says at once that the ERLS may not hold."""
    scene = arm(STIFF)
    profile = torque_profile(scene)
    hard = lambda t: 20.0 * profile(t)  # noqa: E731
    run = simulate(scene, hard, 0.1)
    said = [w for w in run.warnings if w.startswith("auto:")]
    assert len(said) == 1
    assert "torque reaches" in said[0] and "that the formulation was decided over" in said[0]
    assert "erls may be off by more than the tolerance: give co_moving" in said[0]
    stopped = simulate(arm(STIFF, auto={"beyond": "stop"}), hard, 0.1)
    assert "erls may be off" in stopped.status
    on = simulate(arm(STIFF, auto={"beyond": "switch_on"}), hard, 0.1)
    assert np.array_equal(on.link_end, simulate(in_formulation(scene, "co_moving"), hard, 0.1).link_end)
    assert "run again with them" in on.warnings[0]


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ({"reduction": {"modes": 1}}, "reduction takes formulation: erls"),
        ({"effects": {"coriolis": False}}, "effects.coriolis is false"),
        (
            {
                "erls": {
                    "zeroed": [{"link": "l1", "node": 2, "dof": "y"}, {"link": "l2", "node": 0, "dof": "rz"}]
                }
            },
            "erls.zeroed is a list",
        ),
    ],
)
def test_a_scene_that_frames_do_not_take_stays_with_the_erls(keys, why):
    """Then nothing can say how far the ERLS is off, and the decision says that, and why."""
    decision = resolve_effects(arm(SOFT, **keys))
    assert decision.scene.formulation == "erls"
    said = decision.sentences()[0]
    assert "how far it is off isn't known, for co_moving does not take the scene" in said
    assert why in said
    assert decision.chosen.off == 0.0 and decision.chosen.apart is None


def test_a_scene_at_rest_decides_nothing():
    decision = resolve_effects(arm(STIFF, torque=[], effects="auto"))
    assert decision.scene.formulation == "co_moving"
    assert decision.at_rest
    assert decision.left_out == ()
    assert "decides nothing, and this one is exact" in decision.sentences()[0]
    assert resolve_effects(arm(STIFF, torque=[])).at_rest


def test_the_roots_are_never_taken_undamped():
    """There q swings with the elastic modes; with damping, which then stays on, or chords, they may be."""
    roots = {"erls": {"zeroed": "root"}}
    undamped = resolve_effects(arm(STIFF, damping={}, **roots))
    assert undamped.scene.formulation == "co_moving"
    assert "q swings with the elastic modes" in undamped.sentences()[0]
    off = resolve_effects(arm(STIFF, effects={"damping": False}, **roots))
    assert off.scene.formulation == "co_moving"
    damped = resolve_effects(arm(STIFF, tolerance=1e-2, effects={"damping": "auto"}, elements=4, **roots))
    assert damped.scene.formulation == "erls"
    assert damped.left_out == ()
    assert resolve_effects(arm(STIFF, damping={})).scene.formulation == "erls"


def test_steps_and_meshes_are_no_matter_of_the_formulation():
    """Doubled until they no longer decide: at 4 ms the integrators part by more than what is allowed."""
    scene = in_formulation(arm(STIFF, solver={"step": 4e-3}), "co_moving")
    other, trial = in_formulation(scene, "erls"), Trial(scene)
    coarse = trial.distance(other)[0]
    found = distance_of(trial, other, DOUBLINGS, 0.4 * coarse)
    assert found.most <= 0.4 * coarse
    assert finer(scene, 2).solver.step == 2e-3
    assert finer(scene, 2).links[0].beam.elements == 4


@pytest.mark.parametrize(
    ("method", "zeroed", "elements", "formulation"),
    [
        ("rosenbrock_w", "auto", 1, "co_moving"),
        ("rosenbrock_w", "root", 2, "co_moving"),
        ("generalized_alpha", "chord", 4, "co_moving"),
        ("rosenbrock_w", "auto", 4, "erls"),
    ],
)
def test_the_cheaper_one_is_that_whose_steps_cost_less(method, zeroed, elements, formulation):
    """Where both hold, what is taken is the one that steps faster, measured side by side."""
    scene = arm(STIFF, tolerance=1e-2, elements=elements, solver={"method": method}, erls={"zeroed": zeroed})
    decision = resolve_effects(scene)
    assert decision.scene.formulation == formulation
    assert "the cheaper one" in decision.sentences()[0]
    costs = step_costs({name: in_formulation(scene, name) for name in ("erls", "co_moving")}, rounds=25)
    dearer = costs["co_moving"].ratio if formulation == "erls" else 1.0 / costs["co_moving"].ratio
    assert dearer > 0.97


def test_a_mesh_that_is_too_coarse_for_the_tolerance_is_said():
    """One element a link: both formulations would need more, and neither is the better one for it."""
    decision = resolve_effects(arm(2e9, tolerance=1e-4, elements=1, duration=0.05))
    assert decision.scene.formulation == "co_moving"
    assert "twice the elements change either by" in decision.sentences()[0]


def test_cheap_frames_are_not_taken_where_only_they_need_more_elements(monkeypatch):
    """Were the ERLS good enough with its mesh and co-moving frames not, the ERLS would be taken."""
    from flexsim_node.analysis import formulations

    changes = {"co_moving": 1e-3, "erls": 1e-6}
    monkeypatch.setattr(formulations, "twice_the_elements", lambda _, scene: changes[scene.formulation])
    chosen = formulations.choose_formulation(arm(STIFF, elements=1, duration=0.05), 1e-4, 2e-4)
    assert chosen.scene.formulation == "erls"
    assert "the cheaper co_moving needs more elements: twice as many change 1 mm" in chosen.sentence()


def test_a_scene_that_runs_in_neither_is_said():
    """Nothing is decided by runs that stop."""
    with pytest.raises(ArithmeticError, match="the run that effects are judged by stopped at"):
        resolve_effects(arm(STIFF, solver={"method": "runge_kutta_4", "step": 1e-3}))


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"formulation": "auto"}, "formulation: is auto, but the scene has no tolerance to decide by; give"),
        ({"formulation": "automatic"}, "formulation: is 'automatic'; give 'erls', 'co_moving' or 'auto'"),
    ],
)
def test_mistakes_are_named(keys, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene(robot(link("l1", {"a": 0.5}), **keys))
