"""A scene's text with some values changed keeps every other byte, and says what was meant."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import numpy as np
import pytest
from flexsim.study.scene_text import CannotEdit, edit, plain
from flexsim.study.writing import put, written

from flexsim_node import load_scene

CONFIG = Path(__file__).parents[2] / "config"

COLUMNS = """# top
model: robot
gravity: [0.0, -9.81, 0.0]        # along -y
links:
  - name: a     # upper
    beam: {width: 0.03, elements: 2}   # first
  - name: b
    beam: {width: 2.50e-2, elements: 2}   # second
solver: {method: rosenbrock_w, step: 1.0e-3}   # to be changed
# end
"""


def lines_changed(before: str, after: str) -> list[tuple[str, str]]:
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    assert len(old) == len(new)
    return [(a, b) for a, b in zip(old, new, strict=True) if a != b]


def test_only_the_value_changes() -> None:
    """Comments stay in their columns, and a number keeps the manner of the one before."""
    after = edit(COLUMNS, {"solver.step": 5e-4, "links.b.beam.elements": 4, "gravity": [0.0, 0.0, 0.0]})
    assert lines_changed(COLUMNS, after) == [
        ("gravity: [0.0, -9.81, 0.0]        # along -y\n", "gravity: [0.0, 0.0, 0.0]        # along -y\n"),
        ("    beam: {width: 2.50e-2, elements: 2}   # second\n",
         "    beam: {width: 2.50e-2, elements: 4}   # second\n"),
        ("solver: {method: rosenbrock_w, step: 1.0e-3}   # to be changed\n",
         "solver: {method: rosenbrock_w, step: 5.0e-4}   # to be changed\n"),
    ]  # fmt: skip


def test_what_has_its_value_is_left() -> None:
    assert edit(COLUMNS, {"solver.step": 0.001, "gravity": [0, -9.81, 0]}) == COLUMNS


def test_line_ends_and_a_byte_order_mark_stay() -> None:
    dos = "\ufeff" + COLUMNS.replace("\n", "\r\n")
    after = edit(dos, {"solver.step": 5e-4, "erls.zeroed": "root"})
    assert after.startswith("\ufeff# top\r\n")
    assert after.count("\n") == after.count("\r\n") == dos.count("\n") + 1


@pytest.mark.parametrize(
    ("text", "changes", "after"),
    [
        ("a: 1\ns:\n  x: 1 # one\n  # end\n\nb: 2\n", {"s.y": 2},
         "a: 1\ns:\n  x: 1 # one\n  y: 2\n  # end\n\nb: 2\n"),
        ("a: 1", {"b.c": 2}, "a: 1\nb: {c: 2}"),
        ("s:   # why\n\na: 1\n", {"s.x": 1.5}, "s: {x: 1.5}   # why\n\na: 1\n"),
        ("e: auto # all\n", {"e.shear": True}, "e: {shear: true} # all\n"),
        ("{a: 1, b: {}}\n", {"b.c": 2, "a": 2.5}, "{a: 2.5, b: {c: 2}}\n"),
        ("k: [1,\n  2,\n  3]\n", {"k": [1, 5, 3]}, "k: [1,\n  5,\n  3]\n"),
        ("k:\n  - 1\n  - 2\nc: 3\n", {"k": [4]}, "k: [4]\nc: 3\n"),
        ("---\na: 1\n...\n", {"b": 2}, "---\na: 1\nb: 2\n...\n"),
        ("a: 'q'\nb: \"r\"\n", {"a": "s", "b": "t"}, "a: 's'\nb: \"t\"\n"),
        ("t: |\n  one\n  two\nb: 1\n", {"b": 2}, "t: |\n  one\n  two\nb: 2\n"),
        ("a: &q {x: 1, y: 2}\nb: *q\n", {"b.x": 5}, "a: &q {x: 1, y: 2}\nb: {x: 5, y: 2}\n"),
        ("a: &q {x: 1, y: 2}\nb: *q\n", {"a.x": 5}, "a: &q {x: 5, y: 2}\nb: {x: 1, y: 2}\n"),
        ("a: &q\n  x: 1\nb:\n  <<: *q\n  z: 1\n", {"b.x": 5},
         "a: &q\n  x: 1\nb:\n  <<: *q\n  z: 1\n  x: 5\n"),
    ],
)  # fmt: skip
def test_forms_of_yaml(text: str, changes: dict, after: str) -> None:
    assert edit(text, changes) == after


def test_random_changes_say_what_was_meant() -> None:
    """Of every scene of config/: any leaf set to another value reads as that, and all else as before."""
    random = np.random.default_rng(1)
    for path in sorted(CONFIG.glob("*.yaml")):
        text = path.read_bytes().decode()
        leaves = list(paths(plain(text)))
        for _ in range(4):
            dotted = leaves[int(random.integers(len(leaves)))]
            value = [0.125, 7, True, "word", [1, 2]][int(random.integers(5))]
            after = edit(text, {dotted: value})
            expected = plain(text)
            place = expected
            *above, last = dotted.split(".")
            for key in above:
                place = place[int(key)] if isinstance(place, list) else place[key]
            place[int(last) if isinstance(place, list) else last] = value
            assert plain(after) == expected, (path.name, dotted)
            assert sum(a != b for a, b in zip(text.splitlines(), after.splitlines(), strict=False)) >= 0


def paths(document: object, above: str = "") -> list[str]:
    if isinstance(document, dict):
        return [p for k, v in document.items() for p in paths(v, f"{above}{k}.")]
    if isinstance(document, list) and document and isinstance(document[0], (dict, list)):
        return [p for k, v in enumerate(document) for p in paths(v, f"{above}{k}.")]
    return [above[:-1]]


@pytest.mark.parametrize("text", ["a: 1\n---\nb: 2\n", "[1, 2]", "a: [1\n"])
def test_what_is_no_scene_is_refused(text: str) -> None:
    with pytest.raises(CannotEdit):
        edit(text, {"a": 2})


def test_links_and_modes_stay(tmp_path: Path) -> None:
    """A symbolic link stays one, and the file that it names keeps its mode and its other names."""
    real = tmp_path / "real.yaml"
    real.write_text("a: 1\n")
    real.chmod(0o640)
    link = tmp_path / "link.yaml"
    link.symlink_to(real)
    put(link, b"a: 2\n")
    assert link.is_symlink()
    assert real.read_text() == "a: 2\n"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    other = tmp_path / "other.yaml"
    os.link(real, other)
    put(real, b"a: 3\n")
    assert other.read_text() == "a: 3\n"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link.yaml", "other.yaml", "real.yaml"]


def test_what_is_written_is_the_studied_scene() -> None:
    path = CONFIG / "planar_double_pendulum.yaml"
    for changes in (
        {"solver.step": 5e-4, "links.1.beam.elements": 4, "effects.shear": True},
        {"reduction": {"modes": 3}, "links.0.reduction": False},
        {"formulation": "co_moving", "erls.zeroed": "root", "reduction": None, "links.0.reduction": None},
    ):
        text = written(path.read_bytes(), changes, load_scene)
        assert load_scene(plain(text.decode())) == load_scene(path, changes).model_copy(
            update={"source": load_scene(plain(text.decode())).source}
        )
        assert text.decode().count("#") == path.read_text().count("#")
