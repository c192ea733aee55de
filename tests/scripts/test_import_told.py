"""`flexsim import`: whatever a URDF holds is taken, or said not to be."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim
from urdf_robots import ARM, BODY, joint, link, robot

from flexsim_node.model.erls import joint_axis
from flexsim_node.scene.load import load_scene

MESH = '<visual><geometry><mesh filename="package://r/a.stl"/></geometry></visual>'


@pytest.fixture
def imported(tmp_path):
    """Import a text; returns its account and its scene."""

    def done(text: str, *words: str, more: str = ""):
        path, scene, added = tmp_path / "r.urdf", tmp_path / "r.yaml", tmp_path / "more.yaml"
        path.write_text(text)
        added.write_text(more)
        words += ("--with", str(added)) if more else ()
        told = CliRunner().invoke(flexsim, ["import", str(path), "-o", str(scene), "--json", *words])
        assert told.exit_code == 0, told.output + str(told.exception)
        return json.loads(told.stdout), load_scene(scene)

    return done


def refused(tmp_path, text: str, *words: str) -> str:
    """What is said of a robot that is not imported."""
    path = tmp_path / "r.urdf"
    path.write_text(text)
    told = CliRunner().invoke(flexsim, ["import", str(path), "-o", str(tmp_path / "r.yaml"), *words])
    assert told.exit_code != 0 and not (tmp_path / "r.yaml").exists()
    return told.output + str(told.exception)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("<mass", "<colour/><mass", "<colour> in <inertial>"),
        ('<mass value="2"/>', '<mass value="2" unit="kg"/>', "unit of <mass>"),
        ("</inertial>", "</inertial><Inertial/>", "<Inertial> in <link>"),
        ("</inertial>", "</inertial><self_collision_checking/>", "<self_collision_checking> in <link>"),
        ("</link>", f"{MESH.replace('</visual>', '<material/></visual>')}</link>", "<material> in <visual>"),
        ("</joint>", "<hardwareInterface/></joint>", "<hardwareInterface> in <joint>"),
        ("</joint>", '<limit lower="-1" uper="1"/></joint>', "uper of <limit>"),
        ("</joint>", '<dynamics damping="1" armature="2"/></joint>', "armature of <dynamics>"),
        ("</joint>", '<safety_controller k_velocity="1"/></joint>', "calibration or safety_controller"),
        ('type="fixed">', 'type="fixed"><dynamics damping="1"/>', "<dynamics> in fixed <joint>"),
        ("</robot>", "<transmission/></robot>", "<transmission>"),
        ("</robot>", "<material/></robot>", "<material>"),
        ("</robot>", "<gazebo/></robot>", "<gazebo>"),
        ('<link name="ground"/>', f'<link name="ground">{MESH}</link>', "meshes of the base"),
        ("</link>", "<collision/></link>", "collision shapes"),
        ('<link name="tool"></link>', '<link name="tool"></link><link name="end"/>'
         + joint("last", "tool", "end", "fixed"), "frames without mass between"),
    ],
)  # fmt: skip
def test_what_is_not_read_is_said(imported, before, after, said):
    """An element or attribute that has no part in the scene, or is misspelt, stands in the account."""
    assert said not in str(imported(ARM)[0]["not_taken"]) or said == "frames without mass between"
    account, _ = imported(ARM.replace(before, after, 1), "--force")
    assert said in str(account["not_taken"])


def test_nothing_is_said_of_what_is_read(imported):
    """The account of a plain arm names nothing as left out."""
    assert imported(ARM)[0]["not_taken"] == []


def test_axis_of_any_length(imported):
    """Its direction counts, the other way round too; its length does not, which is said."""
    account, scene = imported(ARM.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 -2 0"/>', 1))
    assert "shoulder" in str(account["changed"]) and "not of length 1" in str(account["changed"])
    assert "elbow" not in str(account["changed"])
    assert joint_axis(scene.links[scene.link_names.index("upper")]).tolist() == [0, -1, 0]


def test_end_of_a_branch_is_a_tip(imported):
    """A tool that is fixed to the last link keeps its place as a point, whether it has a mass or not."""
    heavy = ARM.replace('<link name="tool"></link>', link("tool"))
    for text, words in ((ARM, ()), (heavy, ("--force",))):
        _, scene = imported(text, *words)
        assert [scene.link_names[n] for n in scene.tips] == ["fore/tool"]
        assert scene.links[-1].end == (0.0, 0.0, 0.3)
    assert scene.links[scene.link_names.index("fore")].rigid.mass == 4.0


def test_degrees_are_in_doubt(imported):
    """A turn of more than a full one is taken, and said."""
    account, _ = imported(ARM.replace("<origin xyz", '<origin rpy="0 0 90" xyz', 1))
    assert "is it in degrees?" in str(account["in_doubt"])


def test_payload_and_start_of_additions_are_kept(imported):
    """What --with adds to a link that bends, or to what the import gave, is there beside the import's own."""
    limit = '<limit lower="1" upper="2"/>'
    text = ARM.replace("</joint>", f"{limit}</joint>", 1)
    beam = ("--beam", "upper=tube:0.03x0.002,aluminium")
    _, alone = imported(text, *beam)
    more = "links: {upper: {payload: {mass: 0.5, center_of_mass: [0, 0, 0.1]}}}\n"
    more += "initial: {velocity: {elbow: 1.0}}\n"
    account, scene = imported(text, *beam, "--force", more=more)
    own, both = (s.links[s.link_names.index("upper")].payload for s in (alone, scene))
    assert both.mass == pytest.approx(own.mass + 0.5)
    moment = own.mass * np.array(own.center_of_mass) + 0.5 * np.array([0.0, 0.0, 0.1])
    assert both.mass * np.array(both.center_of_mass) == pytest.approx(moment)
    assert scene.start("position").tolist() == [1.5, 0.0] and scene.start("velocity").tolist() == [0.0, 1.0]
    assert "middle of their limits" in str(account["changed"])


def test_what_hangs_beside_a_beams_end_is_said(imported):
    """It rides on a rigid arm there, which a person may not have meant."""
    side = joint("side", "upper", "camera", "fixed").replace("0 0 0.3", "0 0.1 0.3")
    account, _ = imported(
        ARM.replace("</robot>", f"{link('camera', '')}{side}</robot>"), "--beam", "upper=round:0.03,steel"
    )
    assert "camera" in str(account["in_doubt"]) and "0.1 m from the end of the beam" in str(
        account["in_doubt"]
    )


def test_beam_without_a_body_has_its_end(imported):
    """A link without a mass of its own may bend: it weighs what its beam weighs."""
    text = ARM.replace(BODY, "", 1)
    _, scene = imported(text, "--beam", "upper=tube:0.03x0.002,aluminium")
    assert scene.links[0].length == pytest.approx(0.3) or scene.links[1].length == pytest.approx(0.3)


CROSS = robot(
    link("a", ""), joint("yaw", "ground", "a"), link("b"),
    joint("yaw_again", "a", "b").replace("0 0 0.3", "0 0.2 0"),
)  # fmt: skip
# roll, pitch without mass, roll: in line where all are at 0
WRIST = robot(
    link("a", ""), joint("roll", "ground", "a", inside='<axis xyz="0 0 1"/>'),
    link("b", ""), joint("pitch", "a", "b"),
    link("c"), joint("roll_again", "b", "c", inside='<axis xyz="0 0 1"/>'),
)  # fmt: skip


def test_joints_that_together_move_no_mass(imported, tmp_path):
    """Two joints about one axis with nothing between are refused; if only at the start it is in doubt."""
    said = refused(tmp_path, CROSS)
    assert "together can move links without mass" in said and "yaw, yaw_again" in said
    assert imported(CROSS, "--hold", "yaw_again")[0]["joints"] == ["yaw"]
    more = "links: {a: {rigid: {mass: 1.0, center_of_mass: [0.1, 0, 0]}}}\n"
    assert imported(CROSS, "--force", more=more)[0]["joints"] == ["yaw", "yaw_again"]
    account, _ = imported(WRIST, "--force")
    assert "roll, roll_again" in str(account["in_doubt"]) and "another initial position" in str(
        account["in_doubt"]
    )
    account, _ = imported(WRIST, "--force", more="initial: {position: {pitch: 0.3}}\n")
    assert "initial position" not in str(account["in_doubt"])


def test_materials_have_three_numbers(tmp_path):
    """A fourth one is no slip to pass over."""
    assert "is no material" in refused(tmp_path, ARM, "--beam", "upper=round:0.03,7e10:2700:0.3:5")
