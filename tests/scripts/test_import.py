"""`flexsim import`: what it takes, changes and refuses, in words."""

from __future__ import annotations

import json
import sys

import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim
from flexsim.robot_import.sections import beam_of
from urdf_robots import ARM, BODY, joint, link, robot

from flexsim_node.scene.load import load_scene


@pytest.fixture
def run(tmp_path):
    """Import a text; returns the exit code, what was printed, and the scene's path."""

    def imported(text: str | bytes, *words: str, name: str = "r.urdf"):
        path, scene = tmp_path / name, tmp_path / "r.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        done = CliRunner().invoke(flexsim, ["import", str(path), "-o", str(scene), *words])
        said = done.output + (str(done.exception) if done.exception else "")
        return done, said, scene

    return imported


def accepted(run, text, *words) -> dict:
    """The account of an import that is done."""
    done, said, _ = run(text, "--json", *words)
    assert done.exit_code == 0, said
    return json.loads(done.stdout)


def test_arm_is_taken(run):
    """The scene is valid, and the account says what became of each part."""
    limit = '<limit lower="-1" upper="1" effort="30" velocity="2"/><dynamics damping="0.5" friction="0.2"/>'
    text = robot(
        link("upper"), joint("shoulder", "ground", "upper", inside=limit), link("hand"),
        joint("wrist", "upper", "hand", "fixed"), link("tool", ""), joint("flange", "hand", "tool", "fixed"),
    )  # fmt: skip
    account = accepted(run, text)
    done, _, path = run(text, "--force")
    scene = load_scene(path)
    assert done.exit_code == 0 and scene.joint_names == ("shoulder",)
    assert scene.joints[0].effort_limit == 30.0 and scene.joints[0].viscous_friction == 0.5
    assert scene.joints[0].coulomb_friction == 0.2
    assert [scene.link_names[n] for n in scene.tips] == ["upper/tool"]
    upper = scene.links[scene.link_names.index("upper")]
    assert upper.rigid.mass == 4.0 and upper.rigid.center_of_mass == pytest.approx((0.0, 0.0, 0.25))
    assert "position limits" in str(account["not_taken"]) and "velocity" in str(account["not_taken"])
    assert "hand" in str(account["changed"]) and "tool" in str(account["changed"])


def test_fixed_links_may_stay(run):
    """With --keep-fixed each URDF link but the root is a link."""
    accepted(run, ARM, "--keep-fixed")
    names = load_scene(run(ARM, "--keep-fixed", "--force")[2]).link_names
    assert {"upper", "fore", "tool"} <= set(names)


def test_links_bend(run, tmp_path):
    """A beam in words, and springs, rotors and loops of a second file."""
    more = tmp_path / "more.yaml"
    more.write_text(
        "joints: {elbow: {stiffness: 2000.0, rotor_inertia: 1.0e-4, gear_ratio: 50.0}}\n"
        "loops: [{links: [fore, base], joint: spherical, at: {base: [0, 0, 0.9]}}]\nduration: 0.5\n"
    )
    run(ARM, "--beam", "upper=box:0.04x0.03x0.003,steel,5", "--with", str(more))
    scene = load_scene(tmp_path / "r.yaml")
    upper = scene.links[scene.link_names.index("upper")]
    assert upper.beam.elements == 5 and upper.length == pytest.approx(0.3)
    assert upper.beam.area == pytest.approx(0.04 * 0.03 - 0.034 * 0.024)
    own = upper.beam.density * upper.beam.area * upper.length
    assert upper.payload.mass + own == pytest.approx(2.0)
    assert scene.joints[1].stiffness == 2000.0 and scene.duration == 0.5 and len(scene.loops) == 1


def test_beam_that_does_not_fit(run):
    """A beam with more inertia than its link keeps mass and centre; a heavier one is said to weigh more."""
    long = ARM.replace('<origin xyz="0 0 0.3"/>', '<origin xyz="0 0 0.6"/>')
    account = accepted(run, long, "--beam", "upper=tube:0.05x0.002,steel")
    assert "mass and centre together are the URDF's; principal moments go from" in str(account["changed"])
    upper = load_scene(run(long, "--beam", "upper=tube:0.05x0.002,steel", "--force")[2]).links
    link = next(k for k in upper if k.name == "upper")
    own = link.beam.density * link.beam.area * link.length
    assert own + link.payload.mass == pytest.approx(2.0)
    centre = own * 0.3 + link.payload.mass * (0.6 + link.payload.center_of_mass[2])
    assert centre / 2.0 == pytest.approx(0.1)
    heavy = accepted(run, long, "--beam", "upper=round:0.05,steel", "--force")
    assert "for the URDF's 2 kg, which is less" in str(heavy["changed"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("tube:0.05x0.03,steel", "has a wall that fills it"),
        ("tube:0.05,steel", "has no 2 sizes"),
        ("pipe:0.05x0.003,steel", "is no section"),
        ("tube:0.05x0.003,wood", "is no material"),
        ("tube:0.05x0.003", "is no beam"),
        ("tube:0.05x0.003,steel,0", "is no number of elements"),
        ("tube:nanx0.003,steel", "has no 2 sizes"),
    ],
)
def test_beams_that_are_none(run, words, said):
    """A slip in a flag is said, and nothing is written."""
    with pytest.raises(ValueError, match=said):
        beam_of(words)
    done, told, path = run(ARM, "--beam", f"upper={words}")
    assert done.exit_code != 0 and said in told and not path.exists()


def test_section_constants_are_the_rectangles():
    """A box almost full is the rectangle; a tube is a round bar less the hole."""
    box, full = beam_of("box:0.04x0.02x0.0099999,steel"), 0.04 * 0.02**3 / 12.0
    assert box["iy"] == pytest.approx(full, rel=1e-3)
    bar, hole, tube = (beam_of(f"{s},steel") for s in ("round:0.05", "round:0.04", "tube:0.05x0.005"))
    for key in ("area", "iy", "iz", "j"):
        assert tube[key] == pytest.approx(bar[key] - hole[key])


def one(body: str = BODY, kind: str = "revolute", inside: str = "") -> str:
    """A robot of one link on one joint."""
    return robot(link("a", body), joint("j", "ground", "a", kind, inside))


BAD_BODY = BODY.replace('izz="0.01"', 'izz="0.09"')
DOCTYPE = b'<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>'
REFUSED = {
    "no XML": ("links: []", "not XML"),
    "nothing": ("", "not XML"),
    "bytes": (b"\xff\xfe\x00\x01" * 50, "not XML"),
    "entities": (DOCTYPE + ARM.encode(), "has a DOCTYPE"),
    "another document": ("<html/>", "is no robot"),
    "SDF": ("<sdf><model/></sdf>", "is SDF"),
    "MJCF": ("<mujoco/>", "is MJCF"),
    "xacro in a URDF": ('<robot name="r"><xacro:arm/></robot>', "is xacro"),
    "no links": ("<robot/>", "has no links"),
    "no parent": (robot(link("a"), joint("j", "nowhere", "a")), "has the parent 'nowhere'"),
    "no child": (robot(link("a"), joint("j", "ground", "nowhere")), "has the child 'nowhere'"),
    "two roots": (robot(link("a"), link("b"), joint("j", "ground", "a")), "has 2 roots, ground, b"),
    "two parents": (
        robot(
            link("a"), link("b"), joint("j", "ground", "a"), joint("k", "ground", "b"), joint("l", "a", "b")
        ),
        "which k holds already",
    ),
    "a circle": (robot(link("a"), link("b"), joint("j", "a", "b"), joint("k", "b", "a")), "in a circle"),
    "all in a circle": ('<robot name="r">' + link("a") + joint("j", "a", "a") + "</robot>", "in a circle"),
    "a name twice": (robot(link("a"), link("a"), joint("j", "ground", "a")), "is there twice"),
    "a joint twice": (
        robot(link("a"), link("b"), joint("j", "ground", "a"), joint("j", "a", "b")), "is there twice",
    ),
    "not a number": (one(BODY.replace('"2"', '"nan"')), "finite"),
    "infinite": (one(BODY.replace("0 0 0.1", "0 0 inf")), "3 finite"),
    "two numbers": (one(BODY.replace("0 0 0.1", "0 0.1")), "3 finite"),
    "negative mass": (one(BODY.replace('"2"', '"-2"')), "is -2; give kg"),
    "no such body": (one(BAD_BODY), "link 'a' has an inertia that no"),
    "no mass": (one(""), "--hold j"),
    "a zero axis": (
        one(inside='<axis xyz="0 0 0"/>'), "has the axis 0 0 0",
    ),
    "planar": (one(kind="planar"), "'planar', which slides in a plane"),
    "floating": (one(kind="floating"), "'floating', which moves freely"),
    "of no kind": (one(kind="hinge"), "is of type 'hinge'"),
    "no joint that moves": (one(kind="fixed"), "no joint that moves"),
    "kilometres": (
        robot(link("a"), joint("j", "ground", "a").replace("0 0 0.3", "0 0 300")), "metres, not millimetres",
    ),
    "drives itself": (
        one(inside='<dynamics damping="-1"/>'), "would drive the joint",
    ),
    "limits turned round": (
        one(inside='<limit lower="1" upper="-1"/>'), "lower below upper",
    ),
    "a thousand": ("<robot>" + "".join(map(link, map(str, range(1001)))) + "</robot>", "at most 1000"),
    "deep": ("<robot>" + "<a>" * 5000, "lies in"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_no_robot_is_refused(run, kind):
    """One sentence with the place and what would be right; nothing is written."""
    text, said = REFUSED[kind]
    done, told, path = run(text)
    assert done.exit_code == 1
    assert said in told and "\n" not in str(done.exception).strip()
    assert not path.exists()


def test_no_file(run, tmp_path):
    """A path that leads nowhere, or to a folder."""
    for path in (tmp_path / "none.urdf", tmp_path):
        done = CliRunner().invoke(flexsim, ["import", str(path), "-o", str(tmp_path / "s.yaml")])
        assert done.exit_code == 1 and "no such file" in str(done.exception)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (one(BODY.replace('"2"', '"2000"')), "is it in grams?"),
        (one(BODY.replace("0 0 0.1", "0 0 100")), "is it in mm?"),
        (
            robot(link("a"), link("b"), joint("j", "ground", "a"), joint("k", "a", "b").replace("0.3", "50")),
            "is it in mm?",
        ),
        (
            robot(link("a", BODY.replace("0.02", "2e4").replace("0.01", "1e4")), joint("j", "ground", "a")),
            "is it in kg mm2?",
        ),
        (robot(link("a", BODY + '<visual><geometry><mesh filename="none.stl"/></geometry></visual>'),
               joint("j", "ground", "a")), "no such file"),
    ],
)  # fmt: skip
def test_what_is_in_doubt_is_said(run, text, said):
    """It is taken: but a person is told what looks like another unit, or is not there."""
    assert said in str(accepted(run, text)["in_doubt"])


def test_what_is_changed_is_said(run):
    """Mimics, mended inertias, limits without 0, a joint without axis, a link called base."""
    limit = '<limit lower="-2" upper="-1" effort="0"/>'
    text = robot(
        link("a", BAD_BODY), joint("j", "ground", "a", inside=limit).replace('<axis xyz="0 1 0"/>', ""),
        link("base"), joint("k", "a", "base", inside='<mimic joint="j" multiplier="2"/>'),
    )  # fmt: skip
    account = accepted(run, text, "--mend-inertia")
    assert "follows j" in str(account["not_taken"]) and "effort limit 0" in str(account["not_taken"])
    changed = str(account["changed"])
    for said in ("is 1 0 0", "is called base_link", "0.02, 0.02, 0.09 to 0.02, 0.02, 0.04", "middle of"):
        assert said in changed
    held = accepted(run, text, "--mend-inertia", "--hold-mimics", "--force")
    assert held["joints"] == ["j"]


def test_a_scene_is_kept(run):
    """An existing scene is written over with --force only."""
    assert run(ARM)[0].exit_code == 0
    done, told, path = run(ARM)
    assert done.exit_code == 1 and "exists already" in told
    before = path.read_text()
    done, told, _ = run("<html/>", "--force")
    assert done.exit_code == 1 and path.read_text() == before


def test_wrong_words(run):
    """Invalid arguments end with 2."""
    for words in (["--beam", "upper"], ["--arg", "a:=1"], ["--beam", "a=b", "--beam", "a=c"]):
        assert run(ARM, *words)[0].exit_code == 2
    assert "--hold nothing: is no joint" in run(ARM, "--hold", "nothing")[1]
    assert "'nothing' is not there" in run(ARM, "--beam", "nothing=round:0.02,steel")[1]


def test_xacro_is_unfolded_or_refused(run, monkeypatch):
    """Where the package is missing, the refusal says how to convert."""
    monkeypatch.setitem(sys.modules, "xacro", None)
    done, told, path = run(ARM, name="r.urdf.xacro")
    assert done.exit_code == 1 and "flexsim[xacro]" in told and "> r.urdf" in told and not path.exists()


@pytest.mark.parametrize("macro", ["2.0", "${1 / 0}"])
def test_xacro(run, macro):
    """With the package, arguments and macros count; its errors are one sentence."""
    text = ARM.replace('value="2"', f'value="{macro}"').replace(
        "<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '
    )
    done, told, path = run(text, name="r.xacro")
    assert (done.exit_code == 0) == (macro == "2.0"), told
    assert path.exists() == (macro == "2.0")
    if macro != "2.0":
        assert "xacro can't unfold it" in told and "\n" not in str(done.exception)


def test_arguments_of_a_xacro(run):
    """They count; one that the file does not have is refused, where xacro would pass over it."""
    text = ARM.replace('value="2"', 'value="$(arg weight)"', 1).replace(
        '<robot name="r">',
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="weight" default="1"/>',
    )
    done, told, path = run(text, "--arg", "weight:=3", name="r.xacro")
    assert done.exit_code == 0, told
    assert max(k.rigid.mass for k in load_scene(path).links if k.rigid) == 3.0
    done, told, _ = run(text, "--force", "--arg", "wieght:=3", name="r.xacro")
    assert done.exit_code == 1 and "--arg wieght: the xacro has no such argument; it has weight" in told
