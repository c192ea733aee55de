"""What sensors read under loads: against the path of the tip and weights in closed form."""

import numpy as np
import pytest
from scenes import link, robot
from test_sensors import LENGTH, LINE, E, G, at_rest, rotation

from flexsim_node import SceneError, load_scene, simulate
from flexsim_node.equations.dynamics.end_acceleration import Jumps
from flexsim_node.motion.simulation import Simulation

STILL = {"j": lambda t: (0.0, 0.0, 0.0)}
RATE = 2.0 * np.pi * 5.0


def cantilever(step: float, method: str = "rosenbrock_w", **keys) -> dict:
    """A clamped strip with an IMU at its end."""
    return robot(
        link("beam", {"a": LENGTH}, 0.01, 0.03, joint={"name": "j"}, beam={"elements": 4}),
        gravity=[0.0, 0.0, 0.0], damping={"beta": 2e-5}, solver={"method": method, "step": step},
        sensors=[{"name": "imu", "type": "imu"}], **keys,
    )  # fmt: skip


def part(load: np.ndarray, t: float) -> np.ndarray:
    """A load that grows from nothing and falls again, five times a second."""
    return load * (1.0 - np.cos(RATE * t))


def error(readings: np.ndarray, path: np.ndarray, step: float) -> float:
    """Largest difference between an IMU in a tip that hardly turns and its path's, by the signal's size."""
    right = (path[2:] - 2.0 * path[1:-1] + path[:-2]) / step**2
    later = slice(len(right) // 3, None)  # the start rings
    return float(np.max(np.abs(readings[1:-1] - right)[later]) / np.max(np.abs(right[later])))


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
@pytest.mark.parametrize("formulation", ["erls", "co_moving"])
@pytest.mark.parametrize(
    ("place", "load"), [("beam", [0, 10, 0, 0, 0, 0]), ("base:beam", [0, 0, 0, 0, 0, 1])]
)
def test_imu_under_a_wrench(method, formulation, place, load):
    """At 1 ms within 2 % of the signal, and of second order, whichever modes the load moves."""
    errors = []
    for step in (1e-3, 5e-4):
        scene = load_scene(cantilever(step, method, formulation=formulation))
        wrench = {place: lambda t: part(np.array(load, float), t)}
        run = simulate(scene, duration=0.15, prescribed=STILL, wrench=wrench)
        errors.append(error(run.sensors["imu"][:, 4], run.link_end[:, 0, 1], step))
    assert errors[0] < 0.02
    assert errors[1] < 0.4 * errors[0]


def test_imu_under_held_loads():
    """A force that is held over each step reads like a smooth one, though it jumps in every step."""
    errors = []
    for step in (1e-3, 5e-4):
        now = Simulation(load_scene(cantilever(step)), held=("j",))
        readings, path = [], []
        for k in range(round(0.15 / step)):
            readings.append(now.sense()["imu"][4])
            path.append(now.look().link_end[0, 1])
            now.apply("beam", part(np.array([0.0, 10.0, 0, 0, 0, 0]), k * step))
            assert now.step() == 0
        errors.append(error(np.array(readings), np.array(path), step))
    assert errors[0] < 0.02
    assert errors[1] < 0.5 * errors[0]


def test_reading_does_not_change_the_motion():
    """A run is the same to the last bit whether its IMU is read in every step or never."""
    ends = []
    for read in (True, False):
        now = Simulation(load_scene(cantilever(1e-3)), held=("j",))
        for k in range(20):
            now.apply("beam", part(np.array([0.0, 10.0, 0, 0, 0, 0]), k * 1e-3))
            if read:
                now.sense()
            assert now.step() == 0
        ends.append(np.concatenate([now.x, now.v]))
    assert np.array_equal(*ends)


def test_what_is_foreseen_of_a_held_load():
    """Half of the coming jump for a ramp; nothing for a single step of a load, nor for one that turns."""
    jumps = Jumps(1)
    jumps.begin(np.zeros(1))
    for k in (1.0, 2.0, 3.0):
        jumps.step(np.array([k]), np.array([k]))
    assert jumps.mean()[0] == 3.5
    jumps.step(np.array([2.0]), np.array([2.0]))
    assert jumps.mean()[0] == 2.0
    jumps.begin(np.zeros(1))
    jumps.step(np.array([5.0]), np.array([5.0]))
    assert jumps.mean()[0] == 5.0
    jumps.step(np.array([5.0]), np.array([5.0]))
    assert jumps.mean()[0] == 5.0
    # a load that is continuous has no jumps
    jumps.step(np.array([5.0]), np.array([6.0]))
    jumps.step(np.array([6.0]), np.array([7.0]))
    assert jumps.mean()[0] == 7.0


@pytest.mark.parametrize("gravity", [[G, 0, 0], [0, -G, 0], [0, 0, -G]], ids=["along", "weak", "stiff"])
@pytest.mark.parametrize("modes", [2, 4])
def test_stress_of_a_reduced_link(gravity, modes):
    """Forces and strains under its own weight, at every station, however few modes the link keeps."""
    fractions = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    sensors = [
        {"name": f"{kind}{k}", "type": kind, "fraction": float(f), **keys}
        for kind, keys in (("section_force", {}), ("strain_gauge", {"point": [0.005, 0.015]}))
        for k, f in enumerate(fractions)
    ]
    scene = robot(
        link("beam", {"a": LENGTH}, 0.01, 0.03, beam={"elements": 8}),
        gravity=gravity, sensors=sensors, reduction={"modes": modes},
    )  # fmt: skip
    found = at_rest(scene, [0.0])
    force = np.array([found[f"section_force{k}"] for k in range(5)])
    strain = np.array([found[f"strain_gauge{k}"][0] for k in range(5)])
    rest, pull = LENGTH * (1.0 - fractions), np.array(gravity) * LINE
    moment = rest**2 / 2.0
    right = np.outer(rest, pull)
    assert np.allclose(force[:, :3], right, atol=2e-3 * np.max(np.abs(right)))
    area, about_z, about_y = 0.01 * 0.03, 0.03 * 0.01**3 / 12, 0.01 * 0.03**3 / 12
    expected = pull[0] * rest / (E * area)
    expected = expected - 0.005 * pull[1] * moment / (E * about_z) - 0.015 * pull[2] * moment / (E * about_y)
    assert np.allclose(strain, expected, atol=2e-3 * np.max(np.abs(expected)))


def test_strains_of_a_reduced_link_in_a_loop_are_refused():
    from mechanisms import four_bar

    scene = four_bar(beam={"width": 0.02, "depth": 0.02, "density": 2700.0, "youngs_modulus": 7e10})
    scene["links"][0]["reduction"] = {"modes": 2}
    scene["sensors"] = [{"name": "gauge", "type": "strain_gauge", "link": "crank", "side": "+y"}]
    with pytest.raises(SceneError, match="gauge is on a reduced link"):
        Simulation(load_scene(scene))


@pytest.mark.parametrize(
    ("formulation", "modulus", "bound"), [("co_moving", 1e9, 1e-6), ("erls", 2e11, 1e-6)]
)
def test_forces_are_turned_with_the_section(formulation, modulus, bound):
    """A weight at the end of a weightless strip pulls along base axes: in a section's they are the pose's."""
    fractions = (0.0, 0.3, 0.5, 0.8, 1.0)
    sensors = [
        {"name": f"{kind}{k}", "type": kind, "fraction": f}
        for kind in ("section_force", "pose")
        for k, f in enumerate(fractions)
    ]
    scene = robot(
        link("beam", {"a": LENGTH}, 0.01, 0.03, payload={"mass": 0.3},
             beam={"elements": 4, "youngs_modulus": modulus, "density": 10.1}),
        gravity=[0.0, -G, 0.0], sensors=sensors, erls={"zeroed": "root"}, formulation=formulation,
    )  # fmt: skip
    found = at_rest(scene, [0.3])
    for k, f in enumerate(fractions):
        turn = rotation(found[f"pose{k}"][3:])
        own = 10.1 * 0.01 * 0.03 * LENGTH * (1.0 - f)
        weight = np.array([0.0, -(0.3 + own) * G, 0.0])
        assert np.allclose(found[f"section_force{k}"][:3], turn.T @ weight, atol=bound * 0.3 * G)
        arm = found["pose4"][:3] - found[f"pose{k}"][:3]
        moment = turn.T @ np.cross(arm, [0.0, -(0.3 + 0.5 * own) * G, 0.0])
        assert np.allclose(found[f"section_force{k}"][3:], moment, atol=1e-3 * 0.3 * G * LENGTH)
    if formulation == "co_moving":
        assert abs(turn[1, 0] - np.sin(0.3)) > 0.1  # it is bent far


def test_quaternions_go_on():
    """A joint that turns twice: the quaternion goes on without a jump of sign."""
    scene = robot(
        link("rod", {"a": 0.3}, flexible=False, joint={"name": "j"}),
        sensors=[{"name": "imu", "type": "imu"}, {"name": "tip", "type": "pose"}], solver={"step": 5e-3},
    )  # fmt: skip
    run = simulate(
        load_scene(scene), duration=1.0, prescribed={"j": lambda t: (4 * np.pi * t, 4 * np.pi, 0.0)}
    )
    for q in (run.sensors["imu"][:, 6:], run.sensors["tip"][:, 3:]):
        angle = 4 * np.pi * run.time / 2
        right = np.column_stack([0 * angle, 0 * angle, np.sin(angle), np.cos(angle)])
        assert np.allclose(q, right, atol=1e-9)
