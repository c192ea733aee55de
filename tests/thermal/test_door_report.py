"""A report says the verdict, shows the curves and repeats what went in."""

from html import escape

import pytest
from door_scenes import door

from thermal_node import load_scene, simulate
from thermal_node.analysis.report import write_report


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
