"""A leaf's shape is that of its supports: not of their order, and of none that is a mechanism."""

from __future__ import annotations

import itertools

import pytest
from door_scenes import door

from thermal_node import SceneError, door_model, load_scene
from thermal_node.deformation.leaf import Deformation

WOOL = {"materials.rock_wool.youngs_modulus": 5e5}


def shape(hinges, kind="shell", symmetry="quarter", **deformation):
    bricks = [4, 6] if symmetry == "quarter" else [8, 12]
    scene = load_scene(
        door(
            mesh={"in_plane": bricks, "layers": [1, 4, 1], "symmetry": symmetry},
            deformation={"model": kind, "in_plane": [6, 12], "hinges": hinges, **deformation},
        ),
        WOOL,
    )
    model = door_model(scene)
    return Deformation(model).solve(500.0 - 480.0 * model.nodes[:, 2] / 0.06)


@pytest.mark.parametrize("hinges", [(-0.8, 0.8), (-0.8, 0.0, 0.8), (-0.7, 0.1, 0.5)])
def test_the_order_of_the_hinges_bends_nothing(hinges):
    """In any order, and on the quarter as on the whole leaf."""
    found = [shape(list(order)) for order in itertools.permutations(hinges)]
    found.append(shape(list(hinges), symmetry="none"))
    for one in found[1:]:
        assert one.bow == pytest.approx(found[0].bow, rel=1e-6)
        assert one.gap == pytest.approx(found[0].gap, rel=1e-6)


@pytest.mark.parametrize(
    ("deformation", "names"),
    [
        ({"hinges": [0.8]}, "hinge at 0.8 m and lock at 0 m"),
        ({"hinges": [0.8, 0.8]}, "hinge at 0.8 m and lock at 0 m"),
        ({"lock": None}, "free to turn about the line through them"),
        ({"hinges": [0.1], "lock": None}, "hinge at 0.1 m, and is free to turn about it"),
    ],
)
def test_a_mechanism_is_refused(deformation, names):
    with pytest.raises(SceneError, match=names):
        load_scene(door(deformation={"model": "shell", **deformation}), WOOL)
    load_scene(door(deformation={"model": "none", **deformation}))  # nothing bends


def test_hinges_that_a_mesh_can_not_tell_apart_are_refused():
    with pytest.raises(SceneError, match=r"on its mesh .* give a finer deformation\.in_plane"):
        shape([0.8, 0.801])


@pytest.mark.parametrize(("kind", "layers"), [("shell", 1), ("solid", 2)])
def test_two_hinges_leave_the_thermal_bow_of_theory(kind, layers):
    """Cooke: alpha (H^2 + W^2) dT / (8 d), the middle of a free leaf against its corners."""
    plain = {"density": 7800.0, "specific_heat": 500.0, "conductivity": 40.0}
    stiff = {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "elongation": 1.2e-5}
    scene = {
        "model": "fire_door",
        "leaf": {"height": 2.0, "width": 1.0, "layers": [{"material": "plain", "thickness": 0.05}]},
        "materials": {"plain": plain | stiff},
        "mesh": {"in_plane": [4, 4], "layers": [4], "symmetry": "none"},
        "deformation": {
            "model": kind, "hinges": [0.7, -0.6], "lock": 0.2, "in_plane": [8, 16], "layers": [layers],
        },
    }  # fmt: skip
    model = door_model(load_scene(scene))
    bow = Deformation(model).solve(320.0 - 300.0 * model.nodes[:, 2] / 0.05).bow
    assert bow == pytest.approx(1.2e-5 * (2.0**2 + 1.0**2) * 300.0 / (8.0 * 0.05), rel=0.01)
