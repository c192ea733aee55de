"""A robot that was imported runs as a node: its joints' names, its points, and the URDF that it publishes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim
from robot_process import robot as running_robot
from urdf_robots import BODY, joint, link, robot

pytestmark = pytest.mark.ros
# Names as people give them; a joint about x beside its parent, a tool, and a camera in mid-arm.
TEXT = robot(
    link("arm/upper"), joint("left/shoulder joint", "ground", "arm/upper"),
    link("fore", BODY), joint("elbow", "arm/upper", "fore", "continuous", '<axis xyz="1 0 0"/>'),
    link("tool", ""), joint("flange", "fore", "tool", "fixed"),
    link("camera", ""), joint("mount", "arm/upper", "camera", "fixed"),
)  # fmt: skip


def test_imported_robot_runs_as_a_node(tmp_path: Path) -> None:
    """What it publishes belongs together: its URDF, posed as its joints are, has points where it says."""
    (tmp_path / "r.urdf").write_text(TEXT)
    scene = tmp_path / "r.yaml"
    done = CliRunner().invoke(flexsim, ["import", str(tmp_path / "r.urdf"), "-o", str(scene)])
    assert done.exit_code == 0, done.output
    with running_robot(tmp_path, scene=scene, override__initial__velocity=[0.5, 2.0]) as arm:
        arm.connected()
        arm.until(lambda: arm.time() > 0.2)
        layout = arm.until(lambda: arm.heard["flexsim_node/elastic_layout"])[-1]
        assert layout.link_names == ["arm_upper/start", "arm_upper", "arm_upper/camera", "fore", "fore/tool"]
        text = arm.until(lambda: arm.heard["robot_description"])[-1].data
        model = pinocchio.buildModelFromXML(text)
        assert list(model.names)[1:] == ["left/shoulder joint", "elbow"]

        def both():
            """The last joint state of which there is an elastic state too."""
            elastic = {(m.header.stamp.sec, m.header.stamp.nanosec): m for m in
                       arm.heard["flexsim_node/elastic_state"]}  # fmt: skip
            for state in reversed(arm.states()):
                found = elastic.get((state.header.stamp.sec, state.header.stamp.nanosec))
                if found is not None:
                    return state, found
            return None

        state, elastic = arm.until(both)
    assert list(state.name) == ["left/shoulder joint", "elbow"] and elastic.status == "ok"
    angles, data, q = dict(zip(state.name, state.position, strict=True)), model.createData(), []
    for name in list(model.names)[1:]:
        q += [np.cos(angles[name]), np.sin(angles[name])]
    pinocchio.framesForwardKinematics(model, data, np.array(q))
    nodes = np.array(elastic.position).reshape(-1, 3)
    for name in ("arm_upper/camera", "fore/tool"):
        there = data.oMf[model.getFrameId(name, pinocchio.FrameType.BODY)].translation
        last = max(k for k, n in enumerate(layout.node_link) if layout.link_names[n] == name)
        assert np.allclose(nodes[last], there, rtol=0, atol=1e-9), name
    assert abs(angles["elbow"]) > 0.05
