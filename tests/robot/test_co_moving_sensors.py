"""Sensors with `formulation: co_moving`: soft links, and the ERLS where links are stiff."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot
from test_sensors import G, at_rest, rotation

from flexsim_node import load_scene
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.sensors.instruments import Sensors
from flexsim_node.sensors.observation import Observation

CO_MOVING = {"formulation": "co_moving"}
EVERYWHERE = [
    {"name": f"{kind}_{name}_{100 * f:.0f}", "type": kind, "link": name, "fraction": f, **keys}
    for kind, keys in (("section_force", {}), ("strain_gauge", {"side": "+y"}), ("imu", {}), ("pose", {}))
    for name in ("link_1", "link_2", "link_3")
    for f in (0.0, 0.3, 0.5, 0.9, 1.0)
]


def of_kind(found, kind):
    return np.array([value for name, value in found.items() if name.startswith(kind)])


def test_stiff_robots_read_alike():
    """Ten times stiffer: poses a hundred times nearer, forces and strains ten times."""
    apart = []
    for factor in (1.0, 10.0):
        scene = anthropomorphic(sensors=EVERYWHERE, erls={"zeroed": "root"})
        for part in scene["links"]:
            part["beam"]["youngs_modulus"] *= factor
        one, two = (at_rest({**scene, "formulation": f}, [0.3, 0.5, -0.8]) for f in ("erls", "co_moving"))
        apart.append(
            [
                np.max(np.abs(of_kind(one, kind) - of_kind(two, kind))) / np.max(np.abs(of_kind(one, kind)))
                for kind in ("pose", "section_force", "strain_gauge")
            ]
        )
    (pose, force, strain), nearer = apart[0], apart[0] / np.array(apart[1])
    assert pose < 1e-5
    assert force < 1e-2
    assert strain < 1e-2
    assert np.all(nearer > [70.0, 8.0, 8.0])


def test_what_falls_freely_feels_nothing():
    """A slide that drops with soft links on it: no specific force anywhere, whatever the damping; held, g."""
    sensors = [{"name": f"imu_{k}", "type": "imu", "link": "arm", "fraction": 0.5 * k} for k in range(3)]
    beam = {"youngs_modulus": 5e9}
    scene = robot(
        link("slide", {"alpha": 0.7}, None, joint={"type": "prismatic"}),
        link("arm", {"a": 0.5, "alpha": 0.4}, joint={"type": "fixed"}, beam=beam),
        link("hand", {"a": 0.3, "d": 0.1}, joint={"type": "fixed"}, beam=beam, payload={"mass": 1.0}),
        sensors=sensors, damping={"alpha": 3.0, "beta": 1e-3}, **CO_MOVING,
    )  # fmt: skip
    model = build_model(load_scene(scene))
    view, work, here = Observation(model), workspace(model.chain), Sensors(model)
    x, v, a = np.zeros((3, model.unknowns))
    v[0] = -2.0
    view.look(work, x)
    here.look_exactly(view, work, x, v, np.zeros(1), a)
    assert a[0] == pytest.approx(-G, rel=1e-12)
    for k in range(3):
        assert np.allclose(here.values[f"imu_{k}"][:6], 0.0, atol=1e-9)
    held = at_rest(scene, [0.0])
    for k in range(3):
        assert np.linalg.norm(held[f"imu_{k}"][3:6]) == pytest.approx(G, rel=1e-12)


def test_pose_and_rate_are_those_of_the_motion():
    """What an IMU reads at any station are derivatives of the pose there along the motion; soft links."""
    scene = anthropomorphic(sensors=EVERYWHERE[30:], damping={"alpha": 3.0, "beta": 1e-3}, **CO_MOVING)
    for part in scene["links"]:
        part["beam"].update(youngs_modulus=5e9)
    model = build_model(load_scene(scene))
    rng = np.random.default_rng(2)
    x, v, a = 0.1 * rng.standard_normal((3, model.unknowns))
    x[:3], v[:3], a[:3] = [0.3, 0.5, -0.8], [2.0, -3.0, 4.0], [20.0, 10.0, -30.0]
    view, work, here = Observation(model), workspace(model.chain), Sensors(model)

    def read(t):
        at = x + t * v + 0.5 * t * t * a
        view.look(work, at)
        here.look(view, work, at, v + t * a, a)
        return {name: value.copy() for name, value in here.values.items()}

    h = 1e-4
    before, now, after = (read(t) for t in (-h, 0.0, h))
    for name, imu in now.items():
        if not name.startswith("imu"):
            continue
        places = [reading[name.replace("imu", "pose")] for reading in (before, now, after)]
        turns = [rotation(p[3:]) for p in places]
        assert np.allclose(imu[6:], places[1][3:], atol=1e-14)
        felt = turns[1].T @ ((places[2] - 2 * places[1] + places[0])[:3] / h**2 + [0.0, 0.0, G])
        assert np.allclose(imu[3:6], felt, atol=2e-5 * np.max(np.abs(felt)))
        spin = turns[1].T @ (turns[2] - turns[0]) / (2 * h)
        assert np.allclose(imu[:3], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-5)
    view.look(work, x)
    for k, name in enumerate(("link_1", "link_2", "link_3")):
        assert np.allclose(now[f"pose_{name}_100"][:3], view.link_end[k], atol=1e-14)
