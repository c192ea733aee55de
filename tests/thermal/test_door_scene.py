"""A wrong scene is refused with the file, the line, the key and what would be right."""

import numpy as np
import pytest
from door_scenes import door
from endless_files import endless_files

from thermal_node import SceneError, load_scene, simulate

TEXT = """\
model: fire_door
name: thesis_door
leaf:
  height: 2.0
  width: 1.0
  layers:
    - {material: steel, thickness: 0.001}
    - {material: rock_wool, thickness: 0.058}
    - {material: steel, thickness: 0.001}
  rim: {material: steel, thickness: 0.001}
materials:
  rock_wool:
    density: 120.0
    specific_heat: 1000.0
    conductivity:
      temperature: [10, 100, 300, 600, 1000]
      value: [0.035, 0.043, 0.073, 0.118, 0.178]
furnace: {curve: iso_834}
ambient: 20.0
mesh: {in_plane: [20, 40], layers: [1, 12, 1], symmetry: quarter}
solver: {model: full, step: auto}
"""


@pytest.mark.parametrize(
    ("wrong", "line", "said"),
    [
        (("height: 2.0", "hight: 2.0"), 4, "leaf.hight: unknown key; did you mean 'height'?"),
        (("thickness: 0.058", "thickness: 58"), 8, "metres, not millimetres"),
        (("thickness: 0.058", "thickness: 58 mm"), 8, "give a number"),
        (("thickness: 0.058", "thickness: -0.058"), 8, "give more than 0"),
        (("material: rock_wool", "material: rockwool"), 8, "did you mean 'rock_wool'?"),
        (("density: 120.0", "density: 120 kg/m3"), 13, "give a number"),
        (("0.118, 0.178", "0.0, 0.178"), 17, "conductivity.value.3: is 0; give more than 0"),
        (("300, 600", "600, 300"), 16, "is 300 after 600; give increasing"),
        (("1000]", "1000, 1200]"), 17, "5 entries for 6 temperatures"),
        (("iso_834", "iso"), 18, "'iso_834'"),
        (("ambient: 20.0", "ambient: 293.15"), 19, "degrees Celsius, not kelvin"),
        (("[1, 12, 1]", "[1, 12]"), 20, "one a layer: 3"),
        (("step: auto", "step: -1"), 21, "more than 0 s, or auto"),
        (("model: full", "model: fill"), 21, "'full'"),
        (("model: fire_door", "model: door"), 1, "'fire_door'"),
        (("furnace: {", "furnace: [{"), 18, "not YAML"),
    ],
)
def test_refused_with_its_place(tmp_path, wrong, line, said):
    path = tmp_path / "door.yaml"
    assert wrong[0] in TEXT
    path.write_text(TEXT.replace(*wrong))
    with pytest.raises(SceneError) as refusal:
        load_scene(path)
    message = str(refusal.value)
    assert "\n" not in message
    assert said in message
    if "not YAML" not in said:
        assert message.startswith(f"{path}:{line}: ")


def test_overrides_replace_and_are_checked(tmp_path):
    path = tmp_path / "door.yaml"
    path.write_text(TEXT)
    scene = load_scene(path, {"solver.step": 5.0, "leaf.layers.1.thickness": 0.1})
    assert scene.solver.step == 5.0
    assert scene.leaf.thickness == pytest.approx(0.102)
    with pytest.raises(SceneError, match=r"solver\.stop: unknown key"):
        load_scene(path, {"solver.stop": 5.0})
    with pytest.raises(SceneError, match="give 0 to 2"):
        load_scene(path, {"leaf.layers.7.thickness": 0.1})


@pytest.mark.parametrize(
    ("time", "temperature", "said"),
    [
        ([0.0, 30.0, 300.0], [20.0, 200.0, 500.0], "no measurement from 30 to 300 s"),
        ([0.0, 30.0, 20.0], [20.0, 200.0, 500.0], "time goes from 30 to 20 s"),
        ([0.0, 30.0], [20.0, 200.0, 500.0], "2 times and 3 temperatures"),
        ([0.0, 30.0, 60.0], [20.0, 200.0, float("nan")], "furnace.temperature"),
    ],
)
def test_measured_furnace_with_a_hole_is_refused(time, temperature, said):
    scene = door(furnace={"curve": "measured", "time": time, "temperature": temperature})
    with pytest.raises(SceneError, match=said):
        simulate(load_scene(scene), 60.0)


def test_a_log_that_ends_before_the_test_is_refused():
    furnace = {"curve": "measured", "time": [0.0, 50.0, 100.0], "temperature": [20.0, 300.0, 400.0]}
    scene = load_scene(door(furnace=furnace, solver={"model": "column"}))
    assert simulate(scene, 160.0).status.ok  # 60 s beyond: bridged by its last value
    with pytest.raises(SceneError, match="its log ends at 100 s, the test lasts 600 s"):
        simulate(scene, 600.0)


def test_measured_furnace_from_a_file_bridges_short_gaps(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time_s,furnace_c\n0,20\n30,\n60,120\n90,nan\n120,220\n")
    (tmp_path / "door.yaml").write_text(
        TEXT.replace("{curve: iso_834}", "{curve: measured, file: log.csv}").replace(
            "model: full", "model: column"
        )
    )
    run = simulate(load_scene(tmp_path / "door.yaml"), 120.0, 30.0)
    np.testing.assert_allclose(run.furnace, [20.0, 70.0, 120.0, 170.0, 220.0])
    with pytest.raises(SceneError, match="no measurement from 0 to 60 s"):
        simulate(load_scene(tmp_path / "door.yaml", {"furnace.longest_gap": 45.0}), 120.0, 30.0)
    log.write_text("time_s,furnace_c\n0,20\n30,300\n60,\n")
    with pytest.raises(SceneError, match=r"log\.csv: temperature 3 is nan"):
        simulate(load_scene(tmp_path / "door.yaml"), 120.0, 30.0)


def test_a_furnace_hotter_than_a_table_is_refused_unless_a_rule_is_stated():
    hot = {"curve": "constant", "temperature": 1100.0}
    with pytest.raises(SceneError, match="ends at 1000 °C but the furnace is at 1100 °C"):
        load_scene(door(furnace=hot))
    load_scene(door(furnace=hot), {"materials.rock_wool.conductivity.beyond": "hold"})


def test_a_run_that_leaves_a_table_stops_and_says_where():
    scene = door(furnace={"curve": "hydrocarbon"}, solver={"model": "column"})
    run = simulate(load_scene(scene), 3600.0)
    assert not run.status.ok
    assert "rock_wool" in run.status.reason
    assert "beyond the end of its conductivity table at 1000 °C" in run.status.reason
    assert len(run.time) == len(run.temperature) > 1
    assert np.isfinite(run.temperature).all()
    assert run.status.reason in run.verdict


def test_files_that_never_end(tmp_path):
    """They are refused before they are unfolded, or waited for."""
    for path, said in endless_files(tmp_path, "fire_door"):
        with pytest.raises(SceneError, match=said):
            load_scene(path)
