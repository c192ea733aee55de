"""Two things of a scene that share a name are refused with both their places: one would hide the other."""

from __future__ import annotations

import pytest
from door_scenes import door

from thermal_node import SceneError, load_scene
from thermal_node.furnace.log_file import read_columns

DRY = {"name": "dry", "share": 0.1, "latent_heat": 2e6, "temperature": [100, 150]}
BOARD = {"density": 800.0, "specific_heat": 950.0, "conductivity": 0.2}
CAVITY = {"cavity": 0.02, "emissivity": [0.9, 0.9]}


WOOL = "materials.rock_wool"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {f"{WOOL}.reactions": [DRY, {**DRY, "name": "wet"}, {**DRY, "share": 0.2}]},
            f"{WOOL}.reactions.2.name: is 'dry' like {WOOL}.reactions.0; give each reaction its own name",
        ),
        (
            {f"{WOOL}.moisture": 0.02, f"{WOOL}.reactions": [{**DRY, "name": "moisture"}]},
            f"{WOOL}.reactions.0.name: is 'moisture' like {WOOL}.moisture; give each its own name",
        ),
        (
            {
                "materials.cavity": BOARD,
                "leaf.layers": [
                    {"material": "rock_wool", "thickness": 0.03},
                    CAVITY,
                    {"material": "cavity", "thickness": 0.01},
                ],
                "mesh.layers": None,
            },
            "materials.cavity: is named like the cavity leaf.layers.1; give the material another name",
        ),
        (
            {"probes.points": {"interior_half": {"x": 0.3, "z": 0.01}}},
            "points.interior_half: is named like a point of the set interior in probes.sets; give another",
        ),
        ({"probes.sets": ["ftp", "thesis", "ftp"]}, "probes.sets.2: is 'ftp' like probes.sets.0; give each"),
        (
            {"probes.points": {"a": {"x": 0.1}}, "criteria.points": ["a", "a"]},
            "criteria.points.1: is 'a' like criteria.points.0; give each point once",
        ),
        ({"probes.points": {1: {"x": 0.1}, "1": {"x": 0.2}}}, "keys 1 and '1' are one name; give each its"),
    ],
)
def test_two_of_one_name(changes, said):
    with pytest.raises(SceneError) as refused:
        load_scene(door(), changes)
    assert said in str(refused.value)


def test_a_key_twice_in_a_file(tmp_path):
    """Not the last one in silence: the lines of both."""
    path = tmp_path / "door.yaml"
    path.write_text("model: fire_door\nmaterials:\n  wool: {density: 100.0}\n  board: {}\n  wool: {}\n")
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    assert str(refused.value) == (
        f"{path}:5: not YAML: found duplicate key 'wool', which is in line 3 already; give each its own name"
    )


def test_what_may_be_alike():
    """Layers of one material, points in place of the thesis' own, and reactions that nobody named."""
    unnamed = {key: value for key, value in DRY.items() if key != "name"}
    given = {
        "probes.points": {"tc_1": {"x": 0.1}},
        "materials.rock_wool": {**BOARD, "moisture": 0.01, "reactions": [unnamed, unnamed, DRY]},
    }
    names = [r.name for r in load_scene(door(), given).materials["rock_wool"].all_reactions()]
    assert names == ["moisture", "reactions.0", "reactions.1", "dry"]
    left_out = {"probes.sets": ["ftp"], "probes.points": {"interior_half": {"z": 0.01}}}
    assert "interior_half" in load_scene(door(), left_out).probes.points


def test_one_thermocouple_in_two_units(tmp_path):
    """Of a furnace's log both would count for the mean."""
    path = tmp_path / "log.csv"
    path.write_text("time,furnace_1 [°C],furnace_1 [°F]\n0,20,68\n30,300,572\n")
    with pytest.raises(SceneError) as refused:
        read_columns(path)
    assert str(refused.value) == (
        f"{path}:1: has two columns furnace_1, the 2nd and the 3rd;"
        " give each a name of its own, besides its unit"
    )
    path.write_text("time,furnace (left),furnace (right)\n0,20,20\n30,300,310\n")
    assert list(read_columns(path).plain.values()) == ["time", "furnace (left)", "furnace (right)"]
