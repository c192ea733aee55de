"""A row: what it may be asked, what makes it another row, and whose fault its trouble is."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flexsim.sweep.inputs import read_input
from flexsim.sweep.runs import KNOWN, Misasked, SceneRun, Task
from flexsim.sweep.study_file import StudyFileError, read_study
from flexsim.sweep.tasks import overrides_of, scene_run, tasks_of
from flexsim_core.scene_files import SceneError

from thermal_node.criteria.criterion import Criterion

CONFIG = Path(__file__).parents[2] / "config"
COLUMN = CONFIG / "thesis_door_column.yaml"
TIME = np.array([0.0, 1800.0, 3600.0])


def failed(name: str, kind: str, at: float | None, watched: bool = True) -> Criterion:
    return Criterion(name, "K", 1.0, 2.0, at, "", kind, watched=watched)


CRITERIA = [
    failed("read", "read", 100.0),
    failed("average", "insulation", None),
    failed("anywhere", "insulation1", 1500.0),
    failed("centre", "insulation2", 2400.0),
    failed("gap", "integrity", None, watched=False),
]


def stand_in(monkeypatch: pytest.MonkeyPatch, **changed: Any) -> dict[str, Any]:
    """Put a run of the door in place of the simulation; returns what `simulate` was called with."""
    seen: dict[str, Any] = {}
    run = {
        "time": TIME, "status": SimpleNamespace(ok=True, reason=""), "criteria": CRITERIA,
        "probes": {"unexposed_mean": TIME / 60.0, "unexposed_maximum": TIME / 30.0, "tc_1": TIME},
        "furnace": TIME, "bow": None, "gap": None, "utilisation": None, "verdict": "A-60: all holds",
        "model": SimpleNamespace(furnace=SimpleNamespace()),
    } | changed  # fmt: skip

    def simulate(scene: Any, duration: float, sample_period: float) -> SimpleNamespace:
        seen["scene"] = scene
        return SimpleNamespace(**run)

    monkeypatch.setattr("thermal_node.simulate", simulate)
    return seen


def door(*texts: str, solver: str = "column", files: dict[str, str] | None = None) -> Any:
    """The row of the column, in which some expressions are observed."""
    from flexsim_core.scene_files import plain, read_scene

    observe = {f"q{n}": text for n, text in enumerate(texts)}
    work = SceneRun("fire_door", plain(read_scene(COLUMN, "")), str(COLUMN), 3600.0, 60.0, observe)
    return work(Task("key", {}, {"solver.model": solver}, files or {}))


def observed(*texts: str) -> list[Any]:
    row = door(*texts)
    assert row.observed is not None, row.reason
    return list(row.observed.values())


def test_what_held_and_when_it_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A criterion of each class counts for both classes; what is only read is no failure."""
    stand_in(monkeypatch)
    assert observed("failure_time()", "failure_time('centre')", "failure_time('average')") == [
        1500.0, 2400.0, np.inf,
    ]  # fmt: skip
    held = observed("held('insulation')", "held('insulation1')", "held('insulation2')")
    assert held == pytest.approx([25.0, 25.0, 40.0])


@pytest.mark.parametrize(
    ("verdict", "awarded"),
    [
        ("A-60: all holds", True),
        ("A-60 by insulation alone, EI2 30: all holds", True),
        ("EI2 30, A-60 by insulation alone: all holds", True),
        ("A-60, 60 min of integrity not reached yet: insulation holds", False),
        ("A-60, integrity not judged: nothing more", False),
        ("A-600: all holds", False),
        ("no FTP Code class: A-60, but failed", False),
    ],
)
def test_a_class_is_awarded_where_it_is_earned(
    verdict: str, awarded: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A class that stands in the verdict may not be reached yet."""
    stand_in(monkeypatch, verdict=verdict)
    assert observed("awarded('A-60')") == [awarded]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("max(bow)", "bow: the scene computes no deformation"),
        ("max(probe('tc_99'))", "no probe 'tc_99'; did you mean 'tc_1'?"),
        ("failure_time('centr')", "no criterion 'centr'; did you mean 'centre'?"),
        ("failure_time('gap')", "criterion 'gap' is not judged in this scene"),
        ("criterion('gap')", "criterion 'gap' is not judged in this scene"),
        ("held('integrity')", "no criterion of integrity is judged"),
        ("held('insulated')", "did you mean 'insulation'?"),
    ],
)
def test_what_the_scene_does_not_have(text: str, sentence: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A criterion that nothing has judged has no value, not 0."""
    stand_in(monkeypatch)
    row = door(text)
    assert isinstance(row, Misasked) and sentence in row.row.reason


@pytest.mark.parametrize("text", ["held('insulation')", "failure_time()", "awarded('A-60')"])
def test_a_steady_state_holds_for_no_time(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its one sample is at the end of the test: held for an hour, it would seem."""
    stand_in(monkeypatch)
    row = door(text, solver="steady")
    assert isinstance(row, Misasked) and "a steady state is no fire test" in row.row.reason


def test_what_a_run_warns_of_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    notes = SimpleNamespace(furnace=SimpleNamespace(notes=("tc_2 was in °F",)))
    stand_in(monkeypatch, model=notes)
    assert door("1 + 1").warnings == ("tc_2 was in °F",)


def test_the_machine_s_trouble_is_no_row_s(monkeypatch: pytest.MonkeyPatch) -> None:
    """A full disk would else be kept as the failure of every row, for good."""

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    def impossible(*_: Any) -> None:
        raise ValueError("no such door")

    monkeypatch.setattr("thermal_node.simulate", full)
    with pytest.raises(OSError, match="No space left"):
        door("1 + 1")
    monkeypatch.setattr("thermal_node.simulate", impossible)
    assert door("1 + 1").reason == "no such door"


def robot(
    monkeypatch: pytest.MonkeyPatch,
    tips: tuple[int, ...],
    text: str,
    period: float | None,
    status: str = "ok",
) -> Any:
    called: dict[str, Any] = {}

    def simulate(scene: Any, duration: float, sample_period: float | None) -> SimpleNamespace:
        called["period"] = sample_period
        ends = np.array([[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]] * 3)
        return SimpleNamespace(
            time=TIME, status=status, joint_position=ends[:, :, 0], joint_velocity=ends[:, :, 0],
            torque=ends[:, :, 0], link_end=ends, node_position=ends, rigid_position=0.0 * ends,
            node_names=("a/0", "b/0"), energy=TIME, loop_gap=np.zeros((3, 0)), conditioning=TIME,
            sensors={}, validity={"turn": 0.2}, warnings=("turn is beyond 0.1",),
        )  # fmt: skip

    scene = SimpleNamespace(joint_names=("j1", "j2"), link_names=("a", "b"), tips=tips)
    monkeypatch.setattr("flexsim_node.simulate", simulate)
    monkeypatch.setattr("flexsim_node.load_scene", lambda *_: scene)
    row = SceneRun("robot", {}, "robot.yaml", 1.0, period, {"q": text})(Task("key", {}, {}))
    assert called == {"period": period}
    return row


def test_a_robot_with_several_tips_wants_one_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of them would be as good as any."""
    assert robot(monkeypatch, (1,), "final(x())", None).observed == {"q": 2.0}
    assert robot(monkeypatch, (0, 1), "final(x('a'))", None).observed == {"q": 1.0}
    for text in ("final(x())", "final(deflection())"):
        row = robot(monkeypatch, (0, 1), text, None)
        assert isinstance(row, Misasked) and "has tips a, b; give one" in row.row.reason
    assert robot(monkeypatch, (1,), "1 + 1", None).warnings == ("turn is beyond 0.1",)


def test_a_robot_that_stops_is_a_failed_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever its samples until then would say."""
    row = robot(monkeypatch, (1,), "1 + 1", 0.01, "stopped at 0.3 s: turned too far")
    assert (row.observed, row.reason) == (None, "stopped at 0.3 s: turned too far")


# Studies and their rows


def study(folder: Path, words: str, scene: Path = COLUMN) -> Any:
    path = folder / "study.yaml"
    path.write_text(f"scene: {scene}\nobserve: {{mean: max(unexposed_mean)}}\n{words}")
    return read_study(path, KNOWN)


def key(made: Any, versions: dict[str, str] | None = None) -> str:
    points = [{one.key: one.at(0.5) for one in made.vary}]
    return tasks_of(scene_run(made), made.vary, points, versions or {})[0].key


def test_a_row_is_another_where_anything_it_depends_on_is(tmp_path: Path) -> None:
    """And the same where it is not: an aim, a seed or another input of the study."""
    vary = "vary: {ambient: [20.0]}\n"
    one = key(study(tmp_path, vary))
    for words in (
        "vary: {ambient: [21.0]}",
        "vary: {exposed.emissivity: [0.7]}",
        vary + "set: {exposed.emissivity: 0.7}",
        vary + "duration: 1800",
        vary + "sample_period: 30",
        vary.replace("ambient", "initial"),
    ):
        assert key(study(tmp_path, words)) != one, words
    assert key(study(tmp_path, vary), {"numpy": "0"}) != one
    for words in (
        vary + "ask: {monte_carlo: {confidence: 0.9}}",
        vary + "sample: {method: random, seed: 7}",
        "vary: {ambient: {scale: [1.0]}}",
        "vary: {ambient: [20.0], exposed.emissivity: [0.8]}",
    ):
        assert key(study(tmp_path, words)) == one, words


def log(folder: Path, end: float) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "log.csv").write_text(f"time,furnace\n0,20\n3600,{end}\n")
    scene = folder / "door.yaml"
    text = COLUMN.read_text().replace("{curve: iso_834}", "{curve: measured, file: log.csv}")
    scene.write_text(text)
    return scene


def test_a_furnace_s_log_counts_by_what_is_in_it(tmp_path: Path) -> None:
    """Wherever it lies: parts of a study run on several machines."""
    vary = "vary: {ambient: [20.0]}"
    one = key(study(tmp_path, vary, log(tmp_path / "a", 900.0)))
    assert key(study(tmp_path, vary, log(tmp_path / "b", 900.0))) == one
    assert key(study(tmp_path, vary, log(tmp_path / "b", 901.0))) != one


def test_a_log_that_changes_meanwhile_makes_no_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would be kept under the key of the log that was there before."""
    made = study(tmp_path, "vary: {ambient: [20.0]}", log(tmp_path, 900.0))
    work = scene_run(made)
    (task,) = tasks_of(work, made.vary, [{"ambient": 20.0}], {})
    stand_in(monkeypatch)
    assert work(task).observed == {"mean": 60.0}
    log(tmp_path, 901.0)
    with pytest.raises(OSError, match=r"log\.csv is not what it was when the sweep began"):
        work(task)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("vary: {leaf.layers.1.thickness: [0.1], leaf.layers.1: [{material: steel, thickness: 0.1}]}",
         "vary: leaf.layers.1.thickness and leaf.layers.1 change the same"),
        ("vary: {ambient: [20.0]}\nset: {ambient: 3}", "ambient: is in set also"),
        ("vary: {mesh: [{layers: [1, 2, 1]}]}\nset: {mesh.layers: [1, 20, 1]}", "set: mesh.layers varies"),
        ("vary: {materials.wool.density: {scale: [1.0]}}", "the scene's file has nothing"),
        ("vary: {unexposed.emissivity: {scale: [0.9, 1.1]}}", "is 0 in the scene, and so is any factor"),
        ("vary: {leaf.layers.7.thickness: [0.1]}", "vary: leaf.layers.7.thickness: override"),
    ],
)  # fmt: skip
def test_keys_of_one_place(words: str, sentence: str, tmp_path: Path) -> None:
    """The last one would win, and the other seem to change nothing."""
    with pytest.raises((SceneError, StudyFileError)) as refused:
        scene_run(study(tmp_path, words))
    assert sentence in str(refused.value)


def test_a_name_and_a_number_are_one_place(tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(f"""
scene: {CONFIG / "simple_pendulum.yaml"}
vary: {{links.0.beam.depth: [0.01], links.link_1.beam.depth: [0.02]}}
observe: {{bent: max(deflection())}}
""")
    with pytest.raises(SceneError, match=r"links\.0\.beam\.depth and links\.link_1\.beam\.depth"):
        scene_run(read_study(path, KNOWN))


def test_a_robot_s_samples_are_a_step_apart(tmp_path: Path) -> None:
    """A period of its own would shorten the steps, and a sweep of solver.step see one step."""
    path = tmp_path / "study.yaml"
    path.write_text(f"""
scene: {CONFIG / "simple_pendulum.yaml"}
vary: {{solver.step: [1.0e-3, 2.0e-3]}}
observe: {{bent: max(deflection())}}
""")
    assert read_study(path, KNOWN).sample_period is None


def test_a_factor_is_of_what_the_scene_says() -> None:
    """Of every entry of a list."""
    document = {"a": {"b": [1.0, 2.0]}, "c": 3}
    inputs = (read_input("a.b", {"scale": [2.0]}), read_input("c", {"scale": [0.5]}))
    assert overrides_of(document, inputs, {"a.b": 2.0, "c": 0.5}) == {"a.b": [2.0, 4.0], "c": 1.5}
