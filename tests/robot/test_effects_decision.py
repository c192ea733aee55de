"""`auto` effects: decided by what leaving them out changes, the same everywhere, within the tolerance."""

import numpy as np
import pytest
from scenes import link, robot, two_link

from flexsim_node import SceneError, linearize, load_scene, natural_frequencies, resolve_effects, simulate
from flexsim_node.analysis.decide import SHARE, decide
from flexsim_node.analysis.effects import Trial, envelope_trials
from flexsim_node.analysis.step_cost import step_costs
from flexsim_node.scene.torque_profile import torque_profile
from flexsim_node.scene.variants import with_effect

OPEN = {"effects": "auto", "duration": 0.2, "damping": {"alpha": 2.0, "beta": 5e-4}}


def scene_of(tolerance: float, **keys):
    return load_scene(two_link(**{**OPEN, "tolerance": tolerance, **keys}))


def full(scene):
    """All open effects on."""
    for name in scene.effects.undecided:
        scene = with_effect(scene, name, True)
    return scene


@pytest.mark.parametrize("tolerance", [1e-9, 1e-5, 1e-2])
def test_what_is_left_out_stays_within_the_tolerance(tolerance):
    """The decided scene's tip is within the tolerance of the full scene's, as the decision says."""
    scene = scene_of(tolerance)
    decision = resolve_effects(scene)
    assert not decision.scene.effects.undecided
    right = simulate(full(scene), duration=0.2)
    found = simulate(decision.scene, duration=0.2)
    apart = np.max(np.linalg.norm(found.link_end[:, -1] - right.link_end[:, -1], axis=1))
    assert apart <= decision.together * (1.0 + 1e-6) + 1e-15
    assert decision.together <= SHARE * tolerance
    assert decision.scene.effects.gravity is True  # it falls
    assert decision.scene.effects.torsion is False  # in its plane nothing twists


def off(scene, drive, duration):
    """How far the tip is off where the decided scene is driven so, and what the run warned of."""
    own = simulate(scene, drive, duration)
    right = simulate(full(scene), drive, duration)
    return np.max(np.linalg.norm(own.link_end[:, -1] - right.link_end[:, -1], axis=1)), own


def driven(amplitude, **keys):
    """Two stiff links in a vertical plane, driven by sines."""
    torque = [
        {"joint": "link_1_joint", "type": "sine", "amplitude": amplitude, "frequency": 2.0},
        {"joint": "link_2_joint", "type": "sine", "amplitude": 0.25 * amplitude, "frequency": 3.0},
    ]
    return scene_of(1e-4, **{"torque": torque, "gravity": [0.0, 0.0, 0.0], "duration": 0.2, **keys})


def test_within_the_envelope_the_tolerance_is_kept():
    """Torques up to the margin's multiple of the scene's, and other ones in between: within, unwarned."""
    scene = driven(1.0)
    decision = resolve_effects(scene)
    assert decision.left_out
    profile = torque_profile(scene)
    random = np.random.default_rng(3)
    for _ in range(4):
        scale = random.uniform(0.5, 1.9)
        change, run = off(scene, lambda t, s=scale: s * profile(t), 0.2 * random.uniform(0.5, 1.9))
        assert change <= 1e-4
        assert not [w for w in run.warnings if w.startswith("auto")]


@pytest.mark.parametrize("what", ["torque", "time", "pose"])
def test_who_leaves_the_envelope_is_warned_by_name(what):
    """Decided on a gentle motion and then used in earnest: the run says so at once, with the effects."""
    scene = driven(1.0)
    missing = resolve_effects(scene).envelope.left_out
    assert missing
    profile = torque_profile(scene)
    if what == "torque":
        _, run = off(scene, lambda t: 60.0 * profile(t), 0.2)
    elif what == "time":
        run = simulate(scene, None, 0.5)
    else:
        start = scene.model_copy(
            update={"initial": scene.initial.model_copy(update={"position": (1.0, 0.0)})}
        )
        decided = start.model_copy(update={"effects": resolve_effects(scene).scene.effects})
        envelope = resolve_effects(scene).envelope
        q = simulate(decided, lambda t: np.zeros(2), 0.01).joint_position[0]
        said = envelope.beyond(0.0, q, np.zeros(2), np.zeros(2))
        assert "link_1_joint is at 1 rad or m" in said
        assert missing[0] in said
        return
    said = [w for w in run.warnings if w.startswith("auto:")]
    assert len(said) == 1
    assert all(name in said[0] for name in missing)
    assert {"torque": "torque reaches", "time": "s is beyond"}[what] in said[0]


def test_who_leaves_the_envelope_can_stop_or_have_everything_on():
    scene, hard = driven(1.0, auto={"beyond": "stop"}), 60.0
    profile = torque_profile(scene)
    drive = lambda t: hard * profile(t)  # noqa: E731
    run = simulate(scene, drive, 0.2)
    assert "stopped at" in run.status and "left out are" in run.status
    assert run.time[-1] < 0.02
    again = driven(1.0, auto={"beyond": "switch_on"})
    change, run = off(again, drive, 0.2)
    assert change == 0.0
    assert run.status == "ok"
    assert "run again with them" in run.warnings[0]


def test_a_scene_at_rest_decides_nothing():
    scene = scene_of(1e-4, gravity=[0.0, 0.0, 0.0])
    decision = resolve_effects(scene)
    assert decision.at_rest
    assert decision.left_out == ()
    assert all(value is True for _, value in decision.scene.effects)
    assert "decides nothing" in decision.sentences()[-1]


def test_more_goes_at_a_larger_tolerance():
    """At a nanometre bending and its damping stay; at a centimetre they go, the least important first."""
    fine, coarse = resolve_effects(scene_of(1e-9)), resolve_effects(scene_of(1e-2))
    assert set(fine.left_out) < set(coarse.left_out)
    assert "bending_z" not in fine.left_out
    assert "bending_z" in coarse.left_out
    alone = [c.change for c in coarse.changes]
    assert alone == sorted(alone)


def test_each_alone_is_not_enough():
    """Effects that are each within the tolerance are not left out together where they exceed it."""
    scene = scene_of(1e-2)
    changes = {c.name: c.change for c in resolve_effects(scene).changes}
    names = ("bending_z", "rotary_inertia")
    tolerance = 1.0001 * max(changes[name] for name in names) / SHARE
    both = scene.model_copy(
        update={
            "tolerance": tolerance,
            "effects": full(scene).effects.model_copy(update=dict.fromkeys(names, "auto")),
        }
    )
    decision = resolve_effects(both)
    assert all(c.change <= SHARE * tolerance for c in decision.changes)
    own = Trial(full(both))
    without = with_effect(with_effect(full(both), names[0], False), names[1], False)
    together = max(t.distance(without)[0] for t in (own, *envelope_trials(both, own, both.auto.margin)))
    assert (len(decision.left_out) == 2) == (together <= SHARE * tolerance)
    assert decision.together <= SHARE * tolerance


def test_everything_takes_the_same_decision():
    """simulate, linear models and frequencies are those of the decided scene; a run says what was decided."""
    scene = scene_of(1e-5)
    decided = resolve_effects(scene).scene
    assert decide(scene)[0] == decided
    run, right = simulate(scene, duration=0.05), simulate(decided, duration=0.05)
    assert np.array_equal(run.link_end, right.link_end)
    assert run.decision.left_out == resolve_effects(scene).left_out
    assert right.decision is None
    assert np.array_equal(linearize(scene, [-1.5, 0.0]).A, linearize(decided, [-1.5, 0.0]).A)
    assert np.array_equal(natural_frequencies(scene, [0, 0]), natural_frequencies(decided, [0, 0]))


def test_the_torque_that_a_scene_gives_decides():
    """A joint's friction matters where the joint moves."""
    joint = {"name": "j", "viscous_friction": 0.5}
    rod = link("rod", {"a": 0.5}, 0.01, 0.03, joint=joint)
    keys = {"effects": {"joint_friction": "auto", "gravity": False}, "duration": 0.2, "tolerance": 1e-4}
    still = resolve_effects(load_scene(robot(rod, **keys)))
    assert still.at_rest and still.left_out == ()
    torque = [{"joint": "j", "type": "constant", "amplitude": 2.0}]
    moved = resolve_effects(load_scene(robot(rod, torque=torque, **keys)))
    assert moved.left_out == ()
    assert "without it the tip is" in moved.sentences()[0]


def test_torque_profile():
    """Entries add up; a run without a torque of its own takes the scene's."""
    torque = [
        {"joint": "link_1_joint", "type": "constant", "amplitude": 2.0, "start": 0.1, "end": 0.3},
        {"joint": "link_1_joint", "type": "sine", "amplitude": 3.0, "frequency": 2.0, "offset": 1.0},
        {"joint": "link_2_joint", "type": "table", "time": [0.0, 0.2, 0.4], "value": [0.0, 1.0, -1.0]},
    ]
    scene = load_scene(two_link(torque=torque))
    profile = torque_profile(scene)
    sine = 1.0 + 3.0 * np.sin(4 * np.pi * 0.05)
    assert np.allclose(profile(0.05), [sine, 0.25])
    assert profile(0.1)[0] == pytest.approx(3.0 + 3.0 * np.sin(0.4 * np.pi))
    assert np.allclose(profile(0.3), [1.0 + 3.0 * np.sin(1.2 * np.pi), 0.0])
    assert profile(9.0)[1] == -1.0
    run = simulate(scene, duration=0.1)
    assert np.allclose(run.torque, [profile(t) for t in run.time])
    assert torque_profile(load_scene(two_link())) is None


def test_costs_are_taken_in_turns():
    """The same scene twice costs the same within 20 %; six dofs a node cost more than three."""
    scene = load_scene(two_link())
    found = step_costs({"one": scene, "again": scene, "space": (scene, False)}, rounds=15)
    assert found["one"].ratio == 1.0
    assert found["one"].spread == 0.0
    assert found["space"].ratio - 1.0 > found["space"].spread > 0.0
    assert 0.8 < found["again"].ratio < 1.25
    assert found["space"].ratio > 1.3
    assert 1e-7 < found["one"].step < 1e-2


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"effects": "auto"}, "effects: leave gravity to auto, but the scene has no tolerance"),
        ({"effects": {"axial": "perhaps"}}, "give true, false or auto"),
        ({"tolerance": 0.0}, "tolerance: is 0; give more than 0"),
        (
            {"torque": [{"joint": "link_3_joint", "type": "sine"}]},
            "torque.0.joint: is 'link_3_joint', which does",
        ),
        (
            {"torque": [{"joint": "link_1_joint", "type": "table"}]},
            "give time and value, lists of the same length",
        ),
        (
            {"torque": [{"joint": "link_1_joint", "type": "table", "time": [0, 0], "value": [1, 2]}]},
            "has a time that does not rise",
        ),
        ({"torque": [{"joint": "link_1_joint", "type": "sine", "expression": "t"}]}, "unknown key"),
    ],
)
def test_mistakes_are_named(keys, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene(two_link(**keys))


def test_a_scene_that_does_not_run_is_said():
    """Nothing is decided by a run that stops."""
    scene = scene_of(1e-4, solver={"method": "runge_kutta_4", "step": 1e-3})
    with pytest.raises(ArithmeticError, match="the run that effects are judged by stopped at"):
        resolve_effects(scene)


def test_what_co_moving_frames_hold_is_not_switched():
    """Nobody is told that their centrifugal and Coriolis forces could go; `auto` leaves the others open."""
    scene = scene_of(1e-2, formulation="co_moving", duration=0.02)
    assert "coriolis" not in scene.effects.undecided
    assert "bending_z" in scene.effects.undecided
    change = Trial(full(scene)).change("coriolis")
    assert "hold it by their geometry" in change.trouble
    assert change.change == np.inf
    decided = resolve_effects(scene).scene.effects
    assert decided.coriolis is True
    assert decided.centrifugal is True
