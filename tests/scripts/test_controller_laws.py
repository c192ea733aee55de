"""Input shapers and trajectories against closed forms; the example laws on a robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from flexsim.bench.cases import move
from flexsim.bench.score import Recording, Score, score
from flexsim.controller.laws import LAWS
from flexsim.controller.shaping import for_modes, shaper
from flexsim.controller.trajectory import Trajectory

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation

SCENE = Path(__file__).parents[2] / "config" / "anthropomorphic_geared.yaml"
PERIOD, SETTLE = 2e-3, 1.5


@pytest.mark.parametrize(("frequency", "damping"), [(4.0, 0.0), (4.0, 0.1), (20.0, 0.02)])
def test_shapers_leave_no_vibration_of_their_mode(frequency: float, damping: float) -> None:
    """None of the mode itself; of a mode 5 % beside it ZVD leaves less than ZV, and less than 2 %."""
    zv, zvd = shaper("zv", frequency, damping), shaper("zvd", frequency, damping)
    for each in (zv, zvd):
        assert each.amplitudes.sum() == pytest.approx(1.0)
        assert each.residual(frequency, damping) < 1e-12
    beside = [each.residual(1.05 * frequency, damping) for each in (zv, zvd)]
    assert beside[1] < beside[0] < 0.1
    assert beside[1] < 0.02
    both = for_modes("zv", [(frequency, damping), (3.3 * frequency, damping)])
    assert both.residual(frequency, damping) < 1e-12
    assert both.residual(3.3 * frequency, damping) < 1e-12


def test_a_shaped_step_moves_an_oscillator_to_rest() -> None:
    """Twenty periods of x'' + w^2 x = w^2 u, exactly, under the shaped step."""
    frequency = 3.0
    w = 2.0 * np.pi * frequency
    impulses = shaper("zv", frequency)
    t = np.linspace(impulses.times[-1], impulses.times[-1] + 1.0, 200)
    response = sum(
        a * (1.0 - np.cos(w * (t - late)))
        for a, late in zip(impulses.amplitudes, impulses.times, strict=True)
    )
    np.testing.assert_allclose(response, 1.0, atol=1e-12)


def test_trajectory_is_a_cubic_between_points() -> None:
    """A cubic is met exactly, position and velocity; before and after it stands still."""
    time = np.array([0.1, 0.4, 1.0])

    def cubic(t: np.ndarray) -> np.ndarray:
        return np.stack([t**3 - t, 2.0 * t**2], axis=-1)

    def rate(t: np.ndarray) -> np.ndarray:
        return np.stack([3.0 * t**2 - 1.0, 4.0 * t], axis=-1)

    found = Trajectory(time, cubic(time), rate(time))
    for t in (0.1, 0.25, 0.4, 0.77, 1.0):
        position, velocity = found.at(t)
        np.testing.assert_allclose(position, cubic(np.array(t)), atol=1e-12)
        np.testing.assert_allclose(velocity, rate(np.array(t)), atol=1e-12)
    for t, end in ((0.0, 0), (2.0, -1)):
        position, velocity = found.at(t)
        np.testing.assert_allclose(position, cubic(time)[end], atol=1e-12)
        assert not velocity.any()


@pytest.fixture(scope="module")
def scores() -> dict[str, Score]:
    """Each law on the same move, without a process between it and the robot."""
    scene = load_scene(SCENE)
    wanted = move(scene, None, 0.5)
    until = float(wanted.time[-1]) + SETTLE
    robot = Simulation(scene)
    robot.warm()
    found = {}
    for name, kind in LAWS.items():
        robot.reset()
        law = kind(scene, wanted, PERIOD)
        rows = []
        for k in range(round(until / PERIOD) + 1):
            view = robot.look()
            q, rate = robot.joint_position().copy(), robot.joint_velocity().copy()
            rows.append([k * PERIOD, *q, *rate, *robot.joint_effort(),
                         *view.position[-1], *view.rigid_position[-1]])  # fmt: skip
            robot.command(law.torque(k * PERIOD, q, rate, view.displacement.reshape(-1, 6)[-1].copy()))
            for _ in range(round(PERIOD / robot.step_size)):
                assert robot.step() == 0, robot.reason
        columns = np.split(np.array(rows), [1, 4, 7, 10, 13], axis=1)
        found[name] = score(Recording(columns[0][:, 0], *columns[1:]), wanted, until)
    return found


@pytest.mark.parametrize("name", ["shaped_pd", "lqg"])
def test_laws_that_know_of_the_bending_damp_it(scores: dict[str, Score], name: str) -> None:
    """Less than half the vibration of plain PD after the move, and the tip is at rest far sooner."""
    plain, law = scores["joint_pd"], scores[name]
    assert not plain.lost and not law.lost
    assert plain.vibration > 5e-3
    assert law.vibration < 0.5 * plain.vibration
    assert law.settling < 0.6 * plain.settling


def test_lqg_arrives(scores: dict[str, Score]) -> None:
    """At another place than its model is of, no error is left; it follows as closely as plain PD."""
    assert scores["lqg"].final_error < 1e-4
    assert scores["lqg"].tracking_rms < scores["joint_pd"].tracking_rms


def test_scores_of_a_known_swing() -> None:
    """A tip that swings at 2 Hz about a robot that creeps home: the swing's size, and when it is small."""
    wanted = Trajectory(np.array([0.0, 0.5]), np.array([[0.0], [1.0]]), np.zeros((2, 1)))
    t = np.arange(0.0, 3.0, 1e-3)
    way = np.where(t < 0.5, 2.0 * t, 1.0)
    swing = np.where(t < 0.5, 0.0, 0.02 * np.exp(-1.0 * (t - 0.5)) * np.cos(4.0 * np.pi * (t - 0.5)))
    creep = np.where(t < 0.5, 0.0, -0.1 * np.exp(-(t - 0.5) / 0.05))
    rigid = np.stack([way + creep, 0.0 * t, 0.0 * t], axis=-1)
    tip = rigid + swing[:, None] * [0.0, 0.6, 0.8]
    joint = (way + creep)[:, None]
    found = score(Recording(t, joint, 0.0 * joint, 0.0 * joint, tip, rigid), wanted, 3.0)
    first = 0.02 * np.exp(-0.25)  # the largest swings from 0.1 s on: half a turn, and a whole one
    assert found.vibration == pytest.approx(first * (1.0 + np.exp(-0.25)), rel=0.02)
    assert 0.02 * np.exp(-found.settling) == pytest.approx(0.005, rel=0.15)
    assert not found.lost
