"""An arm that is imported moves as the same arm by Denavit-Hartenberg: that of Universal Robots' UR5."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim

from flexsim_node import load_scene, simulate
from flexsim_node.rotations.roll_pitch_yaw import rotation

HALF = np.pi / 2
# Joint's place and pitch in the parent, its axis; mass, its place along z, moments about x and z:
# as ur_description's ur5_robot.urdf has them
UR5 = [
    ((0, 0, 0.089159), 0.0, "0 0 1", 3.7, 0.0, 0.010267495893, 0.00666),
    ((0, 0.13585, 0), HALF, "0 1 0", 8.393, 0.28, 0.22689067591, 0.0151074),
    ((0, -0.1197, 0.425), 0.0, "0 1 0", 2.275, 0.25, 0.049443313556, 0.004095),
    ((0, 0, 0.39225), HALF, "0 1 0", 1.219, 0.0, 0.111172755531, 0.21942),
    ((0, 0.093, 0), 0.0, "0 0 1", 1.219, 0.0, 0.111172755531, 0.21942),
    ((0, 0, 0.09465), 0.0, "0 1 0", 0.1879, 0.0, 0.0171364731454, 0.033822),
]
# d, a, alpha, theta by Universal Robots; the base of the URDF is turned by pi against theirs
DENAVIT_HARTENBERG = [
    (0.089159, 0.0, HALF, np.pi), (0.0, -0.425, 0.0, 0.0), (0.0, -0.39225, 0.0, 0.0),
    (0.10915, 0.0, HALF, 0.0), (0.09465, 0.0, -HALF, 0.0), (0.0823, 0.0, 0.0, 0.0),
]  # fmt: skip
START = [0.4, -1.0, 1.2, -0.5, 0.7, 0.2]


def urdf(offsets: tuple[float, float, float]) -> str:
    """The arm with these offsets along y of shoulder, elbow and second wrist joint."""
    out = ['<robot name="ur5"><link name="base_link"/>']
    for n, (place, pitch, axis, mass, height, across, along) in enumerate(UR5):
        y = {1: offsets[0], 2: offsets[1], 4: offsets[2]}.get(n, place[1])
        out.append(
            f'<link name="l{n}"><inertial><origin xyz="0 0 {height}"/><mass value="{mass}"/>'
            f'<inertia ixx="{across}" iyy="{across}" izz="{along}"/></inertial></link>'
            f'<joint name="j{n}" type="continuous"><parent link="{f"l{n - 1}" if n else "base_link"}"/>'
            f'<child link="l{n}"/><origin xyz="{place[0]} {y} {place[2]}" rpy="0 {pitch!r} 0"/>'
            f'<axis xyz="{axis}"/></joint>'
        )
    out.append(
        '<link name="tool0"/><joint name="flange" type="fixed"><parent link="l5"/><child link="tool0"/>'
    )
    return "".join([*out, '<origin xyz="0 0.0823 0"/></joint></robot>'])


def imported(folder: Path, text: str, *words: str):
    """The scene that `flexsim import` writes."""
    (folder / "ur5.urdf").write_text(text)
    path = folder / "ur5.yaml"
    done = CliRunner().invoke(flexsim, ["import", str(folder / "ur5.urdf"), "-o", str(path), *words])
    assert done.exit_code == 0, done.output
    return load_scene(path, {"initial.position": START, "solver.step": 1e-3})


def pose(dh: tuple[float, float, float, float]) -> np.ndarray:
    """(4, 4) A = Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    d, a, alpha, theta = dh
    found = np.eye(4)
    found[:3, :3] = rotation([0, 0, theta]) @ rotation([alpha, 0, 0])
    found[:3, 3] = [a * np.cos(theta), a * np.sin(theta), d]
    return found


def by_denavit_hartenberg(scene, offsets: tuple[float, float, float]):
    """The imported arm's bodies and beams on links by Denavit-Hartenberg."""
    links, there, here = [], np.eye(4), np.eye(4)
    by_name = {link.name: link for link in scene.links}
    for n, (dh, (place, pitch, *_)) in enumerate(zip(DENAVIT_HARTENBERG, UR5, strict=True)):
        y = {1: offsets[0], 2: offsets[1], 4: offsets[2]}.get(n, place[1])
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = rotation([0, pitch, 0]), [place[0], y, place[2]]
        there, here = there @ own, here @ pose(dh)
        to = np.linalg.inv(here) @ there  # from the URDF's frame of the link to the other
        link = by_name[f"l{n}"]
        d, a, alpha, theta = dh
        made = {
            "name": f"l{n}",
            "dh": {"d": d, "a": a, "alpha": alpha, "theta": theta},
            "joint": {"name": f"j{n}"},
        }
        bodies = [
            (k, b, center) for k in ("rigid", "payload") for b, center in link.bodies if b is getattr(link, k)
        ]
        for key, body, center in bodies:
            start = center + np.array(link.end or (0.0, 0.0, 0.0))
            inertia = to[:3, :3] @ np.array(body.inertia) @ to[:3, :3].T
            made[key] = {
                "mass": body.mass,
                "center_of_mass": (to[:3, :3] @ start + to[:3, 3]).tolist(),
                "inertia": (0.5 * (inertia + inertia.T)).tolist(),
            }
        if link.beam is not None:
            made["beam"] = link.beam.model_dump(exclude_none=True)
        links.append(made)
    keys = {"initial": {"position": START}, "solver": {"step": 1e-3}}
    return load_scene({"model": "robot", "name": "ur5", "links": links, **keys})


def moves(scene, duration: float):
    """A run with torques that hold the arm up a little."""
    effort = np.array([1.0, -30.0, -10.0, 0.5, 0.3, 0.1])
    run = simulate(scene, lambda t: effort * np.cos(3.0 * t), duration, 0.01)
    assert run.status == "ok"
    return run


def same(one, two) -> None:
    """Joints and the tool's place to 1e-9; the arm has moved."""
    assert np.ptp(one.joint_position[:, 1]) > 0.02
    assert np.max(np.abs(one.joint_position - two.joint_position)) < 1e-9
    assert np.max(np.abs(one.link_end[:, -1] - two.link_end[:, -1])) < 1e-9


def test_imported_arm_moves_as_by_denavit_hartenberg(tmp_path):
    """A UR5 of rigid links over a second, with its offsets, from its URDF and from its maker's parameters."""
    offsets = (0.13585, -0.1197, 0.093)
    scene = imported(tmp_path, urdf(offsets))
    assert [scene.link_names[n] for n in scene.tips] == ["l5/tool0"]
    same(moves(scene, 1.0), moves(by_denavit_hartenberg(scene, offsets), 1.0))


@pytest.mark.parametrize("formulation", ["erls", "co_moving"])
def test_imported_arm_bends_as_by_denavit_hartenberg(tmp_path, formulation):
    """Upper arm and forearm are tubes, with what is left of the URDF's masses on their ends."""
    offsets = (0.0, 0.0, 0.10915)  # else the tubes would not lie where those by Denavit-Hartenberg do
    beams = ("--beam", "l1=tube:0.05x0.002,aluminium,2", "--beam", "l2=tube:0.04x0.002,aluminium,2")
    scene = imported(tmp_path, urdf(offsets), *beams)
    both = [
        load_scene(found.model_dump(), {"formulation": formulation})
        for found in (scene, by_denavit_hartenberg(scene, offsets))
    ]
    assert sum(link.beam is not None for link in both[1].links) == 2
    one, two = (moves(found, 0.3) for found in both)
    same(one, two)
    if formulation == "erls":  # the rigid links of co-moving frames follow the bent ones
        assert np.max(np.abs(one.node_position[:, -1] - one.rigid_position[:, -1])) > 1e-5
