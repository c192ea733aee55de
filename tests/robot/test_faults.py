"""Faults on purpose do what they say, and nothing else, the same in every run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexsim_node import load_scene, simulate
from flexsim_node.motion.faults import Faults
from flexsim_node.motion.simulation import Simulation
from flexsim_node.scene.load import SceneError, faults_from_text

CONFIG = Path(__file__).parents[2] / "config"
STEP = 1e-3


def faulty(*faults: dict[str, object], **keys: object):
    return load_scene(CONFIG / "planar_double_pendulum.yaml", {"faults": list(faults), **keys})


def played(faults: Faults, commands: np.ndarray) -> np.ndarray:
    """What the motors give at the end of each step, (K, m), for a command a step."""
    torque, given = np.zeros((3, 2)), []
    for command in commands:
        faults.arrive(command)
        faults.drive(torque)
        given.append(torque[2].copy())
        faults.advance()
    return np.array(given)


def commanded(*faults: dict[str, object], count: int = 200, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    scene = faulty(*faults, seed=seed)
    commands = np.arange(1.0, 2 * count + 1).reshape(count, 2)
    return commands, played(Faults(scene, STEP, np.full(2, np.inf)), commands)


def test_delay_from_start_to_end() -> None:
    """A delay of five steps while it lasts; the wire keeps the order when it ends."""
    commands, given = commanded({"kind": "delay", "time": 0.005, "start": 0.02, "end": 0.1})
    np.testing.assert_array_equal(given[:20], commands[:20])
    np.testing.assert_array_equal(given[25:100], commands[20:95])
    np.testing.assert_array_equal(given[100:104], commands[95:99])  # those on the way come first
    np.testing.assert_array_equal(given[104:], commands[104:])


def test_jitter_keeps_order_and_bound() -> None:
    commands, given = commanded({"kind": "jitter", "time": 0.004})
    late = (commands[:, 0] - given[:, 0]) / 2.0
    shown = given[:, 0] > 0.0
    assert (np.diff(given[shown, 0]) >= 0.0).all()
    assert late[shown].max() <= 4
    assert 0.5 < late[shown].mean() < 3.5


def test_drop_and_repeat() -> None:
    commands, given = commanded({"kind": "drop", "probability": 0.3}, count=2000)
    kept = (given == commands).all(axis=1)
    assert abs(kept.mean() - 0.7) < 0.04
    lost = np.flatnonzero(~kept)[1:]
    np.testing.assert_array_equal(given[lost], given[lost - 1])  # the last one holds
    commands, given = commanded({"kind": "repeat", "probability": 0.1, "time": 0.003}, count=2000)
    again = (given != commands).all(axis=1)
    assert abs(again.mean() - 0.1) < 0.03
    stale = np.flatnonzero(again)
    np.testing.assert_array_equal(given[stale], commands[stale - 3])


def test_the_seed_decides() -> None:
    """The same seed the same run, another seed another, and faults draw apart from each other."""
    jitter, drop = {"kind": "jitter", "time": 0.004}, {"kind": "drop", "probability": 0.3}
    first = commanded(jitter, drop)[1]
    np.testing.assert_array_equal(first, commanded(jitter, drop)[1])
    assert (first != commanded(jitter, drop, seed=1)[1]).any()


def test_lag_is_a_first_order_response() -> None:
    """Exact at any step, for the joint that is named alone."""
    scene = faulty({"kind": "lag", "time_constant": 0.02, "joints": ["joint_1"]})
    given = played(Faults(scene, STEP, np.full(2, np.inf)), np.ones((100, 2)))
    np.testing.assert_allclose(given[:, 0], 1.0 - np.exp(-STEP * np.arange(1, 101) / 0.02), rtol=1e-12)
    np.testing.assert_array_equal(given[:, 1], 1.0)


def test_saturation_and_effort_limits() -> None:
    scene = faulty({"kind": "saturate", "limit": 3.0, "joints": ["joint_2"]})
    given = played(Faults(scene, STEP, np.array([4.0, 10.0])), np.array([[9.0, 9.0], [-9.0, -2.0]]))
    np.testing.assert_array_equal(given, [[4.0, 3.0], [-4.0, -2.0]])
    push = {"kind": "disturbance", "value": 7.0, "joints": ["joint_2"], "start": 0.1, "end": 0.11}
    pushed = commanded(push)
    difference = pushed[1] - pushed[0]
    np.testing.assert_array_equal(difference[100:110], [[0.0, 7.0]] * 10)
    assert np.count_nonzero(difference) == 10


def test_sensors() -> None:
    """Quantized, biased, frozen, noisy: what is shown, not what is; asking twice shows the same."""
    scene = faulty(
        {"kind": "quantize", "signal": "position", "resolution": 0.01},
        {"kind": "bias", "signal": "velocity", "value": 0.5, "joints": ["joint_1"]},
        {"kind": "freeze", "signal": "velocity", "joints": ["joint_2"], "start": 0.05},
        {"kind": "noise", "signal": "effort", "deviation": 0.1},
    )
    true = simulate(faulty(), None, 0.2, STEP)
    shown = simulate(scene, None, 0.2, STEP)
    np.testing.assert_array_equal(shown.node_position, true.node_position)  # the robot does not notice
    np.testing.assert_allclose(shown.joint_position, np.round(true.joint_position, 2), atol=1e-12)
    np.testing.assert_allclose(shown.joint_velocity[:, 0], true.joint_velocity[:, 0] + 0.5, rtol=1e-12)
    np.testing.assert_array_equal(shown.joint_velocity[:50, 1], true.joint_velocity[:50, 1])
    assert (shown.joint_velocity[50:, 1] == true.joint_velocity[50, 1]).all()
    robot = Simulation(scene, STEP)
    noise = []
    for _ in range(500):
        noise.append(robot.joint_effort().copy())
        np.testing.assert_array_equal(noise[-1], robot.joint_effort())
        robot.step()
    assert np.std(noise) == pytest.approx(0.1, rel=0.1)


def test_a_payload_that_changes_in_flight() -> None:
    """What hangs on the link from its start on is the heavier robot's motion, and no jump before."""
    heavy = {"kind": "payload", "link": "link_2", "mass": 2.0}
    whole = simulate(faulty(heavy), None, 0.3, STEP)
    built = simulate(faulty(**{"links.link_2.payload.mass": 2.0}), None, 0.3, STEP)
    np.testing.assert_allclose(whole.joint_position, built.joint_position, rtol=0, atol=1e-12)
    later = simulate(faulty(heavy | {"start": 0.1, "end": 0.2}), None, 0.3, STEP)
    light = simulate(faulty(), None, 0.3, STEP)
    np.testing.assert_array_equal(later.joint_position[:101], light.joint_position[:101])
    assert abs(later.joint_position[-1] - light.joint_position[-1]).max() > 1e-3
    assert abs(np.diff(later.joint_velocity, axis=0)).max() < 0.2  # taken up at the speed of the link's end
    # From the change on energy is kept but for the damping: no work by the change itself.
    between = later.energy[101:200]
    assert between.max() - between.min() < 0.05 * abs(np.ptp(light.energy)) + 0.05


def test_simulate_runs_the_faults_of_lockstep() -> None:
    """Offline, command by command, is what the stepping loop does in lockstep."""
    scene = faulty(
        {"kind": "delay", "time": 0.004},
        {"kind": "jitter", "time": 0.003},
        {"kind": "drop", "probability": 0.2},
        {"kind": "lag", "time_constant": 0.01},
        {"kind": "noise", "signal": "position", "deviation": 1e-4},
        {"kind": "payload", "link": "link_2", "mass": 0.5, "start": 0.1},
        seed=5,
    )
    torque = np.random.default_rng(0).normal(0.0, 1.0, (100, 2))
    offline = simulate(scene, torque, 0.2, 2e-3)
    robot = Simulation(scene, STEP)
    robot.warm()
    shown = [robot.joint_position()]
    for k, command in enumerate(torque):
        robot.command(command)
        if k == 0:
            robot.prepare()
        robot.step()
        robot.step()
        shown.append(robot.joint_position())
    np.testing.assert_array_equal(shown, offline.joint_position)


@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        ({"kind": "delay"}, "faults.0: lacks time; delay needs time"),
        ({"kind": "late", "time": 1.0}, "faults.0.kind: is 'late'; give 'delay'"),
        ({"kind": "delay", "time": 1.0, "limit": 2.0}, "faults.0.limit: has no meaning for delay"),
        ({"kind": "drop", "probability": 1.5}, "faults.0.probability: is 1.5; give at least 0 and at most 1"),
        ({"kind": "delay", "tme": 1.0}, "faults.0.tme: unknown key; did you mean 'time'?"),
        (
            {"kind": "freeze", "signal": "position", "joints": ["elbow"]},
            "joints.0: is 'elbow', which does not exist",
        ),
        ({"kind": "payload", "link": "link_9", "mass": 1.0}, "faults.0.link: is 'link_9'"),
        ({"kind": "delay", "time": 0.1, "start": 1.0, "end": 0.5}, "faults.0.end: is 0.5, not after start 1"),
    ],
)
def test_what_is_refused(fault: dict[str, object], sentence: str) -> None:
    with pytest.raises(SceneError) as refused:
        faulty(fault)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    "text",
    ["{", "a: 1", "[" * 9999, "x" * 10_001, "[&a [1], *a]", "!!python/object/apply:os.system ['a']", "\x00"],
)
def test_faults_that_somebody_sent(text: str) -> None:
    """Whatever comes, there is one sentence and nothing is run."""
    with pytest.raises(SceneError, match=r"^faults: "):
        faults_from_text(text)


@pytest.mark.parametrize(("name", "link"), [("planar_double_pendulum", "link_2"), ("four_bar", "coupler")])
def test_a_reset_returns_to_rest_under_the_payload(name: str, link: str) -> None:
    """The initial state is found anew where a payload changes it, and is kept where the new one has none."""
    scene = load_scene(CONFIG / f"{name}.yaml", {"initial.shape": "static", "gravity": [0.0, -9.81, 0.0]})
    loaded, heavy, late = (
        load_scene(scene.model_dump(), {"faults": [{"kind": "payload", "link": link, **fault}]})
        for fault in ({"mass": 0.5}, {"mass": 1e9}, {"mass": 0.5, "start": 0.004})
    )
    robot, fresh = Simulation(scene), Simulation(loaded)
    empty = robot.x.copy()
    robot.set_faults(loaded)
    np.testing.assert_array_equal(robot.x, empty)  # until a reset
    robot.reset()
    np.testing.assert_array_equal(robot.x, fresh.x)
    assert abs(robot.x - empty).max() > 1e-6
    with pytest.raises(ArithmeticError, match="no static equilibrium"):
        robot.set_faults(heavy)
    robot.reset()
    np.testing.assert_array_equal(robot.x, fresh.x)
    robot.set_faults(late)
    robot.reset()
    np.testing.assert_array_equal(robot.x, empty)
