"""Many runs at once: each is that of `simulate`, bit for bit, whichever thread makes it."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link
from test_effects_decision import driven

from flexsim_node import SceneError, load_scene, simulate, simulate_many
from flexsim_node.motion.simulation import Simulation

EVERYTHING = (
    "joint_position", "joint_velocity", "torque", "link_end", "node_position", "rigid_position",
    "node_displacement", "energy",
)  # fmt: skip
STARTS = np.array([[0.1, -0.2], [0.0, 0.3], [-0.4, 0.2]])


def same(many, k, one):
    """Whether run k of many is this one, in everything that was kept."""
    kept = len(one.time)
    assert many.samples[k] == kept
    assert many.status[k] == one.status
    assert many.warnings[k] == one.warnings
    for name, values in many.outputs.items():
        np.testing.assert_array_equal(values[k, :kept], getattr(one, name), err_msg=name)
        assert np.all(np.isnan(values[k, kept:]))
    for name, values in many.validity.items():
        assert values[k] == one.validity[name], name


def pd(time, position, velocity, given, memory, torque):
    """Joint PD: given are stiffness and damping; it counts how often it is asked."""
    memory[0] += 1.0
    for i in range(torque.size):
        torque[i] = -given[0] * position[i] - given[1] * velocity[i]


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"formulation": "co_moving"},
        {"solver": {"method": "generalized_alpha", "step": 1e-3}},
        {"initial": {"position": [0.0, 0.2], "shape": "static"}},
        {
            "torque": [
                {"joint": "link_1_joint", "type": "sine", "amplitude": 0.4, "frequency": 3.0, "start": 0.0121}
            ]
        },
    ],
    ids=["erls", "co-moving", "generalized-alpha", "static", "torque that jumps"],
)
def test_runs_are_those_of_simulate(keys):
    """Starts differ; everything that is kept is the same to the last bit."""
    scene = load_scene(two_link(**keys))
    many = simulate_many(scene, position=STARTS, duration=0.15, outputs=EVERYTHING)
    for k, start in enumerate(STARTS.tolist()):
        shape = {"initial.shape": scene.initial.shape}
        one = simulate(load_scene(two_link(**keys), {"initial.position": start, **shape}), duration=0.15)
        same(many, k, one)


def test_torques_and_parameters_of_each_robot():
    """An array a robot, samples wider than steps, and a payload of its own: as if each were alone."""
    scene, rng = load_scene(two_link()), np.random.default_rng(3)
    torque = 0.2 * rng.standard_normal((3, 6, 2))
    change = [{"links.1.payload": {"mass": m}} for m in (0.0, 0.1, 0.3)]
    many = simulate_many(
        scene, change, torque=torque, duration=0.12, sample_period=0.02, outputs=EVERYTHING, threads=2
    )
    for k, own in enumerate(change):
        one = simulate(load_scene(two_link(), own), torque[k], duration=0.12, sample_period=0.02)
        same(many, k, one)
    wave = simulate_many(scene, torque=lambda t: np.array([np.sin(20 * t), 0.0]), duration=0.05)
    one = simulate(scene, lambda t: np.array([np.sin(20 * t), 0.0]), duration=0.05)
    np.testing.assert_array_equal(wave.link_end[0], one.link_end)


def test_a_law_is_asked_once_a_period_and_gets_what_python_would_get():
    """The compiled law drives as a loop in Python does, whatever the number of threads."""
    scene = load_scene(anthropomorphic())
    starts = np.random.default_rng(1).uniform(-0.3, 0.3, (5, 3))
    given = np.array([3.0, 0.05])
    runs = [
        simulate_many(
            scene, position=starts, law=pd, given=given, memory=1, duration=0.1, sample_period=0.01,
            control_period=0.002, outputs=EVERYTHING, threads=threads,
        )
        for threads in (1, 2, 4)
    ]  # fmt: skip
    for other in runs[1:]:
        for name in EVERYTHING:
            np.testing.assert_array_equal(runs[0].outputs[name], other.outputs[name])
    memory, torque = np.zeros(1), np.zeros(3)
    own = load_scene(anthropomorphic(), {"initial.position": starts[2].tolist()})
    plant = Simulation(own)
    ends, torques = [], []
    for k in range(101):
        if k % 2 == 0:
            pd(1e-3 * k, plant.joint_position(), plant.joint_velocity(), given, memory, torque)
            plant.command(torque)
        if k == 0:
            plant.prepare()
        if k % 10 == 0:
            ends.append(plant.look().link_end.copy())
            torques.append(torque.copy())
        plant.step()
    np.testing.assert_array_equal(runs[0].link_end[2], ends)
    np.testing.assert_array_equal(runs[0].torque[2], torques)
    assert np.ptp(torques) > 0.1
    assert memory[0] == 51


def test_efforts_stay_within_their_limits():
    """A law that asks for more gets the limit, as a command does."""
    scene = load_scene(two_link(), {"links.0.joint.effort_limit": 0.01})
    many = simulate_many(
        scene,
        law=pd,
        given=np.array([1e3, 0.0]),
        memory=1,
        position=STARTS,
        duration=0.01,
        outputs=("torque",),
    )
    assert np.max(np.abs(many.torque[:, :, 0])) == 0.01


def test_one_that_stops_does_not_disturb_the_others():
    """A step that fails, and a limit that a look finds, end their own run with the reason of `simulate`."""
    scene = load_scene(two_link())
    hard = np.zeros((3, 2, 2))
    hard[1, 1] = 1e9
    many = simulate_many(scene, torque=hard, duration=0.05, sample_period=0.01, outputs=EVERYTHING)
    for k in range(3):
        same(many, k, simulate(scene, hard[k], duration=0.05, sample_period=0.01))
    assert [s == "ok" for s in many.status] == [True, False, True]
    free = simulate_many(scene, position=STARTS, duration=0.3)
    least, most = np.sort(free.validity["mass_condition"])[[0, -1]]
    assert most > 1.01 * least
    limit = {"validity.mass_condition": {"warn": 0.5 * least, "stop": 0.5 * (least + most)}}
    own = load_scene(two_link(), limit)
    seen = simulate_many(own, position=STARTS, duration=0.3, outputs=EVERYTHING)
    for k, start in enumerate(STARTS.tolist()):
        same(seen, k, simulate(load_scene(two_link(), {**limit, "initial.position": start}), duration=0.3))
    stopped = [s != "ok" for s in seen.status]
    assert any(stopped) and not all(stopped) and all("mass_condition" in s for s in seen.status if s != "ok")
    bad = simulate_many(scene, torque=lambda t: np.array([0.0, np.nan if t > 0.01 else 0.0]), duration=0.05)
    assert "not finite" in bad.status[0]


@pytest.mark.parametrize("beyond", ["warn", "stop", "switch_on"])
def test_the_envelope_of_what_was_decided(beyond):
    """A motion harder than `auto` was decided over ends, warns or is run again, as with simulate."""
    scene = driven(1.0, auto={"beyond": beyond})
    hard = np.full((2, 3, len(scene.joints)), 0.0)
    hard[1, 1:, 0] = 60.0
    many = simulate_many(scene, torque=hard, duration=0.03, sample_period=0.01, outputs=EVERYTHING)
    for k in range(2):
        same(many, k, simulate(scene, hard[k], duration=0.03, sample_period=0.01))
    assert many.samples[1] < 4 or many.warnings[1]


def test_what_python_steps_is_the_same_too():
    """Faults, sensors and loops take their steps from Python."""
    keys = {
        "faults": [{"kind": "disturbance", "start": 0.013, "value": 0.2}],
        "sensors": [{"name": "gauge", "type": "pose", "link": "link_2"}],
    }
    scene = load_scene(two_link(**keys))
    torque = 0.1 * np.ones((2, 3, 2))
    torque[1] *= -1.0
    many = simulate_many(
        scene, torque=torque, duration=0.05, sample_period=0.01, outputs=(*EVERYTHING, "sensors")
    )
    for k in range(2):
        one = simulate(scene, torque[k], duration=0.05, sample_period=0.01)
        same(many, k, one)
        np.testing.assert_array_equal(many.sensors["gauge"][k], one.sensors["gauge"])


def reads_too_far(time, position, velocity, given, memory, torque):
    """There is no third joint."""
    torque[0] = given[7]


def test_what_cannot_be_is_refused_before_any_run():
    """Each with what, where and what would be right."""
    scene = load_scene(two_link())

    def few(time, position):
        pass

    def gives_back(time, position, velocity, given, memory, torque):
        return 1.0

    def of_words(time, position, velocity, given, memory, torque):
        torque[0] = position.words

    refused = [
        ({"outputs": ("tip",)}, "no 'tip'"),
        (
            {"position": np.zeros((2, 3))},
            r"position has shape \(2, 3\); give finite values of shape \(2, 2\)",
        ),
        (
            {"position": np.zeros((2, 2)), "velocity": np.zeros((3, 2))},
            "position is for 2, velocity is for 3",
        ),
        ({"overrides": []}, "overrides is for no robot"),
        ({"law": pd, "torque": np.zeros((1, 2))}, "both given"),
        ({"memory": 2}, "a law's"),
        ({"law": few}, r"the law few: .*give a function \(time, position"),
        ({"law": gives_back}, "the law gives_back returns float64"),
        ({"law": of_words}, "the law of_words can't be compiled"),
        (
            {"law": pd, "sample_period": 0.01, "control_period": 0.003},
            "no whole multiple of control_period 0.003",
        ),
        ({"duration": -1.0}, "duration -1.0"),
        ({"threads": 0}, "threads 0"),
        ({"law": reads_too_far, "given": np.zeros(1)}, "robot 0: the law reads or writes beyond"),
    ]
    for keys, said in refused:
        with pytest.raises(ValueError, match=said):
            simulate_many(scene, **{"duration": 0.01, **keys})
    with pytest.raises(SceneError, match=r"robot 1: .*links.0.beam.width"):
        simulate_many(scene, [{}, {"links.0.beam.width": -1.0}], duration=0.01)
    with pytest.raises(ValueError, match="robot 1: its node_position has shape"):
        simulate_many(
            scene, [{}, {"links.0.beam.elements": 3}], duration=0.01, outputs=("node_position",), threads=1
        )
    with pytest.raises(AttributeError, match="link_end was not kept"):
        _ = simulate_many(scene, duration=0.01, outputs=("energy",)).link_end


def test_a_law_that_drives_what_has_no_motor():
    """Its run ends there, and says so."""
    scene = load_scene(
        robot(link("a", {"a": 0.5}), link("b", {"a": 0.4}, joint={"actuated": False}), gravity=[0, -9.81, 0])
    )
    many = simulate_many(scene, law=pd, given=np.array([1.0, 0.1]), memory=1, position=STARTS, duration=0.01)
    assert "b_joint, which is passive" in many.status[0]
    assert list(many.samples) == [1, 1, 1]
