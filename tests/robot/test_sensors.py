"""Virtual sensors: against statics and dynamics in closed form, against the motion, against each other."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link

from flexsim_node import SceneError, linearize, load_scene, simulate, static_equilibrium
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.motion.rest_shape import rest_shape
from flexsim_node.motion.simulation import Simulation
from flexsim_node.sensors.instruments import Sensors
from flexsim_node.sensors.observation import Observation

LENGTH, G = 0.5, 9.81
LINE = 7800 * 0.01 * 0.03  # kg/m
E = 2e11
FRACTIONS = np.linspace(0.0, 1.0, 9)
ROOT = {"zeroed": "root"}


BOTH = pytest.mark.parametrize("formulation", ["erls", "co_moving"])


def at_rest(scene: dict, position: list[float]) -> dict[str, np.ndarray]:
    """Readings of a robot that is held still."""
    model = build_model(load_scene(scene))
    x = rest_shape(model, np.array(position))
    view, work, sensors = Observation(model), workspace(model.chain), Sensors(model)
    view.look(work, x)
    sensors.look(view, work, x, np.zeros_like(x), np.zeros_like(x))
    return {name: value.copy() for name, value in sensors.values.items()}


def along(kind: str, **keys) -> list[dict]:
    """Sensors of one kind from start to end of the only link."""
    return [
        {"name": f"{kind}_{k}", "type": kind, "link": "beam", "fraction": float(f), **keys}
        for k, f in enumerate(FRACTIONS)
    ]


@BOTH
@pytest.mark.parametrize("effects", [{}, {"bending_z": False, "axial": False}, {"shear": True}])
def test_cantilever_under_its_own_weight(effects, formulation):
    """M = -mu g (L - x)^2 / 2 and Q = -mu g (L - x) at every station, with one element, whatever bends."""
    sensors = along("section_force") + along("strain_gauge", side="+y")
    scene = robot(
        link("beam", {"a": LENGTH}, 0.01, 0.03, beam={"elements": 1}),
        gravity=[0.0, -G, 0.0], effects=effects, sensors=sensors, erls=ROOT, formulation=formulation,
    )  # fmt: skip
    found = at_rest(scene, [0.0])
    force = np.array([found[f"section_force_{k}"] for k in range(9)])
    rest = LENGTH * (1.0 - FRACTIONS)
    # what is beyond a section is in equilibrium as it is bent, here by 1e-3 rad
    bent = 1e-6 * LINE * G
    assert np.allclose(force[:, 5], -LINE * G * rest**2 / 2, atol=1e-9 + bent * LENGTH**2 / 2)
    # the section turns with the beam; the shear force is the weight's part across it
    assert np.allclose(force[:, 1], -LINE * G * rest, rtol=2e-5, atol=1e-9 + bent * LENGTH)
    strain = np.array([found[f"strain_gauge_{k}"][0] for k in range(9)])
    bending = E * 0.03 * 0.01**3 / 12
    right = 0.005 * LINE * G * rest**2 / 2 / bending if effects.get("bending_z", True) else 0.0 * rest
    assert np.allclose(strain, right, rtol=1e-4, atol=1e-9)


@BOTH
def test_rod_that_hangs(formulation):
    """Tension mu g (L - x) and m g of a mass at its end; gauges all round read the same strain."""
    sensors = along("section_force") + [
        {"name": name, "type": "strain_gauge", "at": 0.2, "side": side}
        for name, side in (("a", "+y"), ("b", "-y"), ("c", "+z"), ("d", "-z"))
    ]
    scene = robot(
        link("beam", {"a": LENGTH}, 0.01, 0.03, payload={"mass": 2.0}),
        gravity=[0.0, -G, 0.0], sensors=sensors, formulation=formulation,
    )  # fmt: skip
    found = at_rest(scene, [-np.pi / 2])
    tension = LINE * G * LENGTH * (1.0 - FRACTIONS) + 2.0 * G
    assert np.allclose([found[f"section_force_{k}"][0] for k in range(9)], tension, rtol=1e-9)
    strain = (LINE * G * 0.3 + 2.0 * G) / (E * 0.01 * 0.03)
    for name in "abcd":
        assert found[name][0] == pytest.approx(strain, rel=1e-6)


@BOTH
def test_gauges_on_four_sides(formulation):
    """Bending about z strains +y and -y oppositely; about y, +z and -z; torsion strains none."""
    places = {"+y": [0.005, 0.0], "-y": [-0.005, 0.0], "+z": [0.0, 0.015], "-z": [0.0, -0.015]}
    sensors = [
        {"name": f"g{k}", "type": "strain_gauge", "fraction": 0.25, "side": side}
        for k, side in enumerate(places)
    ]
    sensors += [
        {"name": f"p{k}", "type": "strain_gauge", "fraction": 0.25, "point": point}
        for k, point in enumerate(places.values())
    ]
    payload = {"mass": 1.0, "center_of_mass": [0.0, 0.1, 0.0]}
    scene = robot(
        link("beam", {"a": LENGTH}, 0.01, 0.03, payload=payload, beam={"density": 10.1}),
        gravity=[0.0, -3.0, -5.0], sensors=sensors, formulation=formulation,
    )  # fmt: skip
    found = at_rest(scene, [0.0])
    arm = 0.75 * LENGTH
    about_z, about_y = E * 0.03 * 0.01**3 / 12, E * 0.01 * 0.03**3 / 12
    y, z = 0.005 * 3.0 * arm / about_z, 0.015 * 5.0 * arm / about_y
    readings = np.array([found[f"g{k}"][0] for k in range(4)])
    assert np.allclose(readings, [y, -y, z, -z], rtol=0.02, atol=0.01 * y)
    assert np.allclose(readings, [found[f"p{k}"][0] for k in range(4)], rtol=1e-12)


@BOTH
def test_rod_that_spins(formulation):
    """N = mu w^2 (L^2 - x^2) / 2 + m w^2 L; the tip is accelerated by w^2 L towards the axis."""
    sensors = [
        *along("section_force"),
        {"name": "imu", "type": "imu"},
        {"name": "middle", "type": "imu", "at": 0.25},
    ]
    beam = link("beam", {"a": LENGTH}, 0.01, 0.03, payload={"mass": 2.0}, flexible=False)
    scene = robot(beam, effects={"gravity": False}, sensors=sensors, initial={"velocity": [7.0]})
    readings = Simulation(load_scene(scene, {"formulation": formulation})).sense()
    right = LINE * 49 * (LENGTH**2 - (LENGTH * FRACTIONS) ** 2) / 2 + 2.0 * 49 * LENGTH
    assert np.allclose([readings[f"section_force_{k}"][0] for k in range(9)], right, rtol=1e-6)
    assert np.allclose(readings["imu"][:3], [0, 0, 7.0])
    assert np.allclose(readings["imu"][3:6], [-49 * LENGTH, 0, 0], atol=1e-9)
    assert np.allclose(readings["middle"][3:6], [-49 * 0.25, 0, 0], atol=1e-9)


@BOTH
def test_specific_force_of_a_pendulum(formulation):
    """Let go from horizontal, a rod's end feels half of g downwards, g - 3/2 g; held, all of it."""
    sensors = [{"name": "imu", "type": "imu"}, {"name": "tip", "type": "pose"}]
    rod = link("rod", {"a": LENGTH}, 0.01, 0.03, flexible=False)
    scene = robot(rod, gravity=[0.0, -G, 0.0], effects={"rotary_inertia": False}, sensors=sensors)
    run = simulate(load_scene(scene, {"formulation": formulation}), duration=0.3)
    assert np.allclose(run.sensors["imu"][0, 3:6], [0.0, -0.5 * G, 0.0], atol=1e-9)
    angle, rate = run.joint_position[:, 0], run.joint_velocity[:, 0]
    imu = run.sensors["imu"]
    # radial: -w^2 L + g sin, tangential: L w' + g cos = -g cos / 2
    assert np.allclose(imu[:, 3], -(rate**2) * LENGTH + G * np.sin(angle), atol=1e-6 * G)
    assert np.allclose(imu[:, 4], -0.5 * G * np.cos(angle), atol=1e-3 * G)
    assert np.allclose(imu[:, 2], rate, atol=1e-12)
    assert np.allclose(run.sensors["tip"][:, :3], run.link_end[:, -1], atol=1e-12)
    half = np.column_stack([0 * angle, 0 * angle, np.sin(angle / 2), np.cos(angle / 2)])
    assert np.allclose(run.sensors["tip"][:, 3:], half, atol=1e-12)
    assert np.allclose(imu[:, 6:], half, atol=1e-12)


@BOTH
@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
def test_imu_equals_differences_of_the_pose(method, formulation):
    """Angular velocity and specific force of a swinging spatial arm are those of its tip's path."""
    scene = anthropomorphic(
        sensors=[{"name": "imu", "type": "imu"}, {"name": "tip", "type": "pose"}],
        damping={"alpha": 0.1, "beta": 1e-3}, initial={"position": [0.2, 0.4, -0.9], "shape": "static"},
        solver={"step": 2e-4, "method": method}, erls=ROOT, formulation=formulation,
    )  # fmt: skip
    rest = static_equilibrium(load_scene(scene), [0.2, 0.4, -0.9]).torque
    run = simulate(
        load_scene(scene),
        lambda t: rest + np.array([3 * np.sin(20 * t), 0.0, 1.0 - np.cos(15 * t)]),
        duration=0.1,
    )
    assert run.status == "ok"
    position, q = run.sensors["tip"][:, :3], run.sensors["tip"][:, 3:]
    h = run.time[1]
    turn = np.array([rotation(k) for k in q])
    acceleration = (position[2:] - 2 * position[1:-1] + position[:-2]) / h**2 + [0, 0, G]
    felt = np.einsum("kji,kj->ki", turn[1:-1], acceleration)
    rate = (turn[2:] - turn[:-2]) / (2 * h)
    spin = np.einsum("kji,kjl->kil", turn[1:-1], rate)
    angular = np.column_stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
    imu = run.sensors["imu"][1:-1]
    # the first milliseconds hold the highest modes, which the step does not follow
    later = run.time[1:-1] > 0.01
    size = np.max(np.abs(felt[later] - [0, 0, 0]))
    assert np.max(np.abs(imu[later, 3:6] - felt[later])) < 5e-3 * size
    assert np.max(np.abs(imu[later, :3] - angular[later])) < 2e-3 * np.max(np.abs(angular))


def rotation(q: np.ndarray) -> np.ndarray:
    """(3, 3) of a quaternion (x, y, z, w)."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize(
    ("effects", "formulation"),
    [
        ({}, "erls"),
        ({"shear": True}, "erls"),
        ({"rotary_inertia": False}, "erls"),
        ({"centrifugal": False}, "erls"),
        ({"coriolis": False}, "erls"),
        ({}, "co_moving"),
        ({"shear": True, "rotary_inertia": False}, "co_moving"),
    ],
)
def test_section_forces_equal_the_equilibrium_of_the_part_beyond(effects, formulation):
    """In any motion what strains and the element's load say equals the inertia of all that is beyond.

    They are two roads to the same six figures; they differ by the elastic rotation, here 3e-4 rad.
    """
    places = (0.0, 0.2, 0.5, 0.50001, 0.9, 1.0)
    sensors = [
        {"name": f"{name}_{k}", "type": "section_force", "link": name, "fraction": f}
        for name in ("link_1", "link_2", "link_3")
        for k, f in enumerate(places)
    ]
    damping = {"alpha": 0.3, "beta": 1e-4}
    scene = anthropomorphic(
        sensors=sensors, effects=effects, erls=ROOT, damping=damping, formulation=formulation
    )
    inertia = [[1e-3, 0, 0], [0, 2e-3, 0], [0, 0, 2e-3]]
    scene["links"][2]["payload"] = {"mass": 0.5, "center_of_mass": [0.02, 0.01, 0.03], "inertia": inertia}
    for part in scene["links"]:
        part["beam"]["youngs_modulus"] = 2e13
    model = build_model(load_scene(scene))
    view, work = Observation(model), workspace(model.chain)
    x = rest_shape(model, np.array([0.3, 0.5, -0.8]))
    x[3:] += 2e-8 * np.sin(np.arange(x.size - 3))
    v, a = 1e-5 * np.cos(np.arange(x.size)), np.zeros(x.size)
    v[:3] = 0.9, -0.7, 1.1
    view.look(work, x)
    strained, beyond = Sensors(model), Sensors(model)
    strained._whole = False  # as in loops
    strained.look_exactly(view, work, x, v, np.array([1.0, 12.0, 3.0]), a)
    beyond.look(view, work, x, v, a)
    one = np.array(list(strained.values.values()))
    two = np.array(list(beyond.values.values()))
    turned = np.max(np.abs(view.displacement[:, 3:]))
    assert turned < 4e-4
    force, moment = np.max(np.abs(two[:, :3])), np.max(np.abs(two[:, 3:]))
    assert np.max(np.abs(one[:, :3] - two[:, :3])) < 2 * turned * force
    bound = 2 * turned * (moment + LENGTH * force)
    assert bound < 6e-3 * moment
    assert np.max(np.abs(one[:, 3:] - two[:, 3:])) < bound


@BOTH
def test_linear_model_of_sensors(formulation):
    """The step response of a gauge, an IMU and a section's moment equals the simulation's within 0.1 %."""
    sensors = [
        {"name": "gauge", "type": "strain_gauge", "link": "link_1", "fraction": 0.3, "side": "+y"},
        {"name": "force", "type": "section_force", "link": "link_2", "at": 0.0},
        {"name": "imu", "type": "imu"},
    ]
    pose = [-1.2, 0.4]
    scene = load_scene(
        two_link(
            sensors=sensors, damping={"alpha": 0.5, "beta": 1e-3}, solver={"step": 5e-5},
            initial={"position": pose, "shape": "static"}, erls=ROOT, formulation=formulation,
        )
    )  # fmt: skip
    model = linearize(scene, pose, ["gauge", "force", "imu"])
    assert model.output_names[:2] == ("gauge", "force/force_x")
    step = np.array([2e-3, -1e-3])
    run = simulate(scene, lambda t: model.torque + step, duration=0.1, sample_period=1e-3)
    found = (
        np.hstack([run.sensors["gauge"][:, None], run.sensors["force"], run.sensors["imu"]]) - model.output
    )
    ahead, drive = model.discretize(1e-3)
    x, right = np.zeros(len(ahead)), []
    for _ in run.time:
        right.append(model.C @ x + model.D @ step)
        x = ahead @ x + drive @ step
    size = np.max(np.abs(right), axis=0)
    moves = size > 1e-9
    assert moves.sum() >= 8  # gauge, N, Q, M, turn rate, two specific forces, orientation
    error = np.max(np.abs(found - right)[10:], axis=0)  # highest modes have died away after 10 ms
    assert np.all(error[moves] < 1e-3 * size[moves])
    assert np.all(error[~moves] < 1e-9)


def test_nothing_is_sensed_unasked():
    scene = load_scene(two_link())
    assert Simulation(scene).sense() == {}
    assert simulate(scene, duration=0.01).sensors == {}


@pytest.mark.parametrize(
    ("sensor", "sentence"),
    [
        (
            {"type": "gauge"},
            "sensors.0.type: is 'gauge'; give 'strain_gauge', 'imu', 'pose' or 'section_force'",
        ),
        ({"type": "strain_gauge"}, r"give side \(\+y, -y, \+z, -z\), or point"),
        ({"type": "strain_gauge", "point": [0.1, 0.0]}, "lies outside the section of link_2, 0.01 x 0.03 m"),
        ({"type": "imu", "side": "+y"}, "which has no side or point"),
        ({"type": "imu", "link": "link_3"}, "is 'link_3', which does not exist; give link_2"),
        ({"type": "imu", "at": 0.6}, "sensors.0.at: is 0.6; link_2 ends at 0.5 m"),
        ({"type": "imu", "at": 0.1, "fraction": 0.1}, "has both at and fraction"),
        ({"type": "imu", "name": "a b"}, "sensors.0.name"),
        ({"type": "strain_gauge", "side": "+y", "link": "link_1"}, "which is rigid and has no strain"),
    ],
)
def test_mistakes_are_named(sensor, sentence):
    scene = two_link(sensors=[{"name": "s", **sensor}])
    scene["links"][0]["flexible"] = False
    with pytest.raises(SceneError, match=sentence):
        load_scene(scene)


def test_names_are_unique():
    twice = [{"name": "s", "type": "imu"}, {"name": "s", "type": "pose"}]
    with pytest.raises(SceneError, match=r"sensors.1.name: is 's' like sensors.0"):
        load_scene(two_link(sensors=twice))
