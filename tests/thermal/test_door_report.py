"""A report says the verdict, shows the curves and repeats what went in."""

from html import escape

import pytest
from door_scenes import door, slab

from thermal_node import load_scene, simulate
from thermal_node.analysis.report import facts, write_report


@pytest.fixture(scope="module")
def run():
    scene = load_scene(
        door(
            mesh={"in_plane": [6, 6], "layers": [1, 6, 1]},
            deformation={"model": "shell", "in_plane": [6, 8]},
        ),
        {"materials.rock_wool.youngs_modulus": 5e5},
    )
    return simulate(scene, 900.0, 60.0)


def test_html_is_one_file_with_its_pictures(run, tmp_path):
    path = write_report(run, tmp_path / "out" / "report.html")
    text = path.read_text(encoding="utf-8")
    assert escape(run.verdict) in text
    assert text.count("data:image/png;base64,") == 4
    assert "mean temperature rise" in text
    assert "rock_wool" in text


def test_markdown_has_its_pictures_beside_it(run, tmp_path):
    path = write_report(run, tmp_path / "report.md")
    text = path.read_text(encoding="utf-8")
    assert f"**{run.verdict}**" in text
    for name in ("furnace", "unexposed", "infrared", "deformation"):
        assert f"report_{name}.png" in text
        assert (tmp_path / f"report_{name}.png").stat().st_size > 5000


def test_another_ending_is_refused(run, tmp_path):
    with pytest.raises(ValueError, match=r"\.html or \.md"):
        write_report(run, tmp_path / "report.pdf")


WET = {"density": 600.0, "specific_heat": 1000.0, "conductivity": 0.2, "moisture": 0.05}


def _moist(**changes):
    return load_scene(slab(0.02, WET, 8, furnace={"curve": "iso_834"}, **changes))


def test_the_heat_that_is_told_adds_up():
    """In, out, taken by water and stored close the balance, and say that they are those of 1 m2."""
    said = dict(facts(simulate(_moist(), 1800.0, 600.0)))
    into, out, taken, stored = (
        float(said[f"heat {name}"].removesuffix(" MJ for 1 m2 of the leaf"))
        for name in (
            "in through the exposed face",
            "out through the unexposed face",
            "taken by what evaporates or leaves",
            "stored",
        )
    )
    assert taken == pytest.approx(0.02 * 600.0 * 0.05 * 2.257, rel=1e-3)
    assert into - out - taken == pytest.approx(stored, abs=3e-3)


def test_a_steady_state_sums_no_heat():
    """It has no duration, so MJ of the way there would mean nothing."""
    said = dict(facts(simulate(_moist(solver={"model": "steady", "of": "column"}), 1800.0, 600.0)))
    assert not any("MJ" in value for value in said.values())
