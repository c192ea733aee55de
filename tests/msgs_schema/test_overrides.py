"""Overrides that lead nowhere are refused by the robot and by the door alike, in the same words."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexsim_node
import thermal_node

CONFIG = Path(__file__).parents[2] / "config"
ROBOT, DOOR = CONFIG / "planar_double_pendulum.yaml", CONFIG / "thesis_door.yaml"


@pytest.mark.parametrize(
    ("robot", "door", "said"),
    [
        ("links.0.beam.width.x", "mesh.in_plane.0.x", "override {key}: {above} is {value} and has no keys "),
        ("gravity.7", "mesh.in_plane.7", "override {key}: no '7' in {above}; give 0 to {last}"),
        ("solver.stepp", "solver.stepp", "{file}, override: {key}: unknown key; did you mean 'step'?"),
        ("gravity.0", "mesh.in_plane.0", "{file}, override: {key}: is 'x'; give a "),
    ],
)  # fmt: skip
def test_an_override_that_leads_nowhere(robot: str, door: str, said: str) -> None:
    found = {"value": ("0.03", "20"), "last": ("2", "1")}
    for n, (key, file) in enumerate(((robot, ROBOT), (door, DOOR))):
        load = (flexsim_node.load_scene, thermal_node.load_scene)[n]
        with pytest.raises(ValueError) as refused:
            load(file, {key: "x"})
        words = {name: values[n] for name, values in found.items()}
        sentence = said.format(key=key, above=key.rpartition(".")[0], file=file, **words)
        assert str(refused.value).startswith(sentence)


def test_keys_below_a_list_that_the_scene_leaves_out() -> None:
    with pytest.raises(ValueError, match=r"deformation\.layers: is a set of keys; give a list"):
        thermal_node.load_scene(DOOR, {"deformation.layers.0.x": 5})
