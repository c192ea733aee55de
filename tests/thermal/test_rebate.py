"""An edge that a rebate leaves half free takes up heat there, and there alone."""

from __future__ import annotations

import numpy as np
import pytest
from door_scenes import door

from thermal_node import SceneError, door_model, load_scene, simulate

MESH = {"in_plane": [6, 6], "layers": [1, 12, 1], "symmetry": "quarter"}
EDGE = {"gas": "furnace", "film_coefficient": 25.0, "emissivity": 0.7}


@pytest.mark.parametrize("discretisation", ["finite_volume", "finite_element"])
@pytest.mark.parametrize("depth", [0.0005, 0.001, 0.02, 0.0317, 0.06])
def test_the_free_part_has_its_area_and_its_middle(depth, discretisation):
    """Of a quarter's two edges, 0.5 and 1 m long; both moments exact, wherever it ends within a brick."""
    scene = load_scene(door(mesh=MESH | {"discretisation": discretisation}, lateral={**EDGE, "depth": depth}))
    model = door_model(scene)
    area = np.asarray(model.surface.area[2])
    z = model.mesh.z[:, None, None]
    assert area.sum() == pytest.approx(1.5 * depth, rel=1e-12)
    assert (area * z).sum() == pytest.approx(1.5 * depth**2 / 2.0, rel=1e-9)
    assert area.min() >= 0.0
    last = int(np.searchsorted(model.mesh.z, depth))
    assert area[last + 1 :].sum() == 0.0


def test_half_an_edge_is_between_a_free_one_and_a_covered_one():
    """At the unexposed face 25 mm from the edge, and in the heat that enters there."""
    found = {}
    for name, lateral in {
        "covered": {}, "half": {**EDGE, "depth": 0.03}, "free": EDGE, "whole depth": {**EDGE, "depth": 0.06},
    }.items():  # fmt: skip
        run = simulate(load_scene(door(mesh=MESH, lateral=lateral)), 1200.0, 600.0)
        assert run.status.ok and run.balance.worst < 1e-6
        found[name] = run.probes["tc_9"][-1]
    assert found["covered"] + 5.0 < found["half"] < found["free"] - 5.0
    assert found["whole depth"] == pytest.approx(found["free"], abs=1.0)


@pytest.mark.parametrize("discretisation", ["finite_volume", "finite_element"])
@pytest.mark.parametrize(
    ("depth", "free"), [(None, 0.002), (0.0005, 0.0005), (0.02, 0.001), (0.0515, 0.0015)]
)
def test_the_closed_mouth_of_a_cavity_takes_no_heat(depth, free, discretisation):
    """Two sheets of 1 mm, 50 mm of air, no rim: of the edge the sheets alone are in the furnace."""
    scene = door(mesh={"in_plane": [4, 4], "layers": [1, 1, 1], "discretisation": discretisation})
    sheet = {"material": "steel", "thickness": 0.001}
    cavity = {"cavity": 0.05, "emissivity": [0.9, 0.9], "convection": "still"}
    scene["leaf"] = {"height": 2.0, "width": 1.0, "layers": [sheet, cavity, sheet]}
    scene["lateral"] = EDGE if depth is None else {**EDGE, "depth": depth}
    model = door_model(load_scene(scene))
    assert np.asarray(model.surface.area[2]).sum() * model.mesh.parts == pytest.approx(6.0 * free, rel=1e-12)
    scene["leaf"]["rim"] = sheet
    model = door_model(load_scene(scene))
    depth = 0.052 if depth is None else depth
    assert np.asarray(model.surface.area[2]).sum() * model.mesh.parts == pytest.approx(6.0 * depth, rel=1e-12)


def test_a_depth_beyond_the_leaf_is_refused():
    with pytest.raises(SceneError, match=r"lateral\.depth: is 0\.07; give at most the leaf's 0\.06 m"):
        load_scene(door(lateral={**EDGE, "depth": 0.07}))
    with pytest.raises(SceneError, match="metres, not millimetres"):
        load_scene(door(lateral={**EDGE, "depth": 30.0}))
