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


PLAIN = {"density": 7800.0, "specific_heat": 500.0, "conductivity": 40.0, "elongation": 1.2e-5}


def plate(kind, width, height, thickness, in_plane, poissons_ratio=0.3, rise=300.0, **deformation):
    """A plate of one elastic material, hotter by `rise` K at its exposed face; its shape."""
    stiff = {"youngs_modulus": 2e11, "poissons_ratio": poissons_ratio}
    layers = deformation.pop("layers", [1 if kind == "shell" else 2])
    scene = {
        "model": "fire_door",
        "leaf": {
            "height": height, "width": width, "layers": [{"material": "plain", "thickness": thickness}],
        },
        "materials": {"plain": PLAIN | stiff},
        "mesh": {"in_plane": [4, 4], "layers": [4], "symmetry": "none"},
        "deformation": {"model": kind, "in_plane": in_plane, "layers": layers, **deformation},
    }  # fmt: skip
    model = door_model(load_scene(scene))
    return Deformation(model).solve(20.0 + rise * (1.0 - model.nodes[:, 2] / thickness))


@pytest.mark.parametrize("kind", ["shell", "solid"])
@pytest.mark.parametrize(
    "held",
    [
        {"hinges": [0.7, -0.6], "lock": 0.2},
        {"hinges": [0.7, -0.6], "lock": 0.2, "hinge_play": 0.002, "lock_play": 0.001},
        {"hinges": [0.0, -0.75, 0.75], "hinge_play": 0.03, "lock_play": 0.03},
        {"hinges": [-0.75, {"height": 0.0, "play": 0.03}, 0.75], "hinge_play": 0.0},
    ],
)
def test_the_bow_of_theory_where_no_hinge_holds_it_back(kind, held):
    """Cooke: alpha (H^2 + W^2) dT / (8 d), the middle of a free leaf against its corners.

    With two hinges, and with three whose play is more than the hinged edge bows.
    """
    bow = plate(kind, 1.0, 2.0, 0.05, [8, 16], **held).bow
    assert bow == pytest.approx(1.2e-5 * (2.0**2 + 1.0**2) * 300.0 / (8.0 * 0.05), rel=0.01)


def test_three_rigid_hinges_hold_the_bow_back():
    """And ones with too little play hold back less of it."""
    free = 1.2e-5 * (2.0**2 + 1.0**2) * 300.0 / (8.0 * 0.05)
    bows = [
        plate("shell", 1.0, 2.0, 0.05, [8, 16], hinges=[0.0, -0.75, 0.75], hinge_play=p).bow
        for p in (0.0, 0.005, 0.03)
    ]
    assert bows[0] < 0.95 * free
    assert bows[0] < bows[1] < bows[2] == pytest.approx(free, rel=0.01)


STRIP = {"width": 0.05, "height": 1.0, "thickness": 0.01, "in_plane": [2, 40], "poissons_ratio": 0.0}
CURVATURE = 1.2e-5 * 200.0 / 0.01
RIGIDITY = 2e11 * 0.05 * 0.01**3 / 12.0


def force_of(shape, beginning):
    return sum(r.force for r in shape.support_forces if r.name.startswith(beginning))


@pytest.mark.parametrize("kind", ["shell", "solid"])
@pytest.mark.parametrize(
    ("clearance", "end"),
    [
        # The middle alone touches: P L^3 / (48 EI) = kappa L^2 / 8 - c, half of P at each end.
        (0.020, 24.0 * RIGIDITY * (CURVATURE / 8.0 - 0.020)),
        (0.012, 24.0 * RIGIDITY * (CURVATURE / 8.0 - 0.012)),
        # Nearer than kappa L^2 / 24 a stretch lies flat; it ends sqrt(6 c / kappa) before the support.
        (0.004, RIGIDITY * CURVATURE / (6.0 * 0.004 / CURVATURE) ** 0.5),
    ],
)
@pytest.mark.parametrize(("opens", "rise"), [("away_from_fire", 200.0), ("towards_fire", -200.0)])
def test_a_strip_against_the_stop_is_a_beam_on_supports(kind, clearance, end, opens, rise):
    """Its middle bows towards the hotter face, where the stop is."""
    shape = plate(
        kind, **STRIP, rise=rise, hinges=[-0.5, 0.5], lock=[-0.5, 0.5], opens=opens,
        stop={"edges": ["hinge", "latch"], "clearance": clearance},
    )  # fmt: skip
    towards = 1.0 if rise > 0.0 else -1.0
    for name in ("hinge at -0.5", "hinge at 0.5", "lock at -0.5", "lock at 0.5"):
        assert force_of(shape, name) == pytest.approx(-0.5 * towards * end, rel=0.01)
    assert force_of(shape, "stop") == pytest.approx(2.0 * towards * end, rel=0.01)
    assert sum(r.force for r in shape.support_forces) == pytest.approx(0.0, abs=1e-6 * end)
    reached = max(abs(out).max() for out in shape.edge_moved.values())
    # Read on the unexposed face; bricks also stretch through the thickness.
    assert reached == pytest.approx(clearance, abs=1e-8 if kind == "shell" else 1.3e-5)


def test_a_stop_on_the_cold_side_of_a_strip_touches_nothing():
    bent = plate("shell", **STRIP, rise=200.0, hinges=[-0.5, 0.5], lock=[-0.5, 0.5], opens="towards_fire")
    assert force_of(bent, "stop, left") == pytest.approx(0.0, abs=1e-6)
    assert max(abs(out).max() for out in bent.edge_moved.values()) == pytest.approx(CURVATURE / 8.0, rel=2e-3)


@pytest.mark.parametrize("kind", ["shell", "solid"])
@pytest.mark.parametrize("play", [0.0, 0.010])
def test_a_hinge_that_gives_is_a_spring_behind_its_play(kind, play):
    """Beam on two supports and a spring in the middle: P (L^3 / (48 EI) + 1 / k) = kappa L^2 / 8 - play."""
    k = 2e4
    middle = {"height": 0.0, "play": play, "stiffness": k}
    shape = plate(
        kind, **STRIP, rise=200.0, hinges=[-0.5, middle, 0.5], lock=[-0.5, middle, 0.5]
    )  # fmt: skip
    force = (CURVATURE / 8.0 - play) / (1.0 / (48.0 * RIGIDITY) + 1.0 / (2.0 * k))
    assert force_of(shape, "hinge at 0 m") == pytest.approx(0.5 * force, rel=0.01)
    assert force_of(shape, "lock at 0 m") == pytest.approx(0.5 * force, rel=0.01)


@pytest.mark.parametrize("opens", ["towards_fire", "away_from_fire"])
def test_a_door_keeps_to_its_side_of_the_stop(opens):
    """Every edge on its side, what touches pushed and never pulled, half a leaf as the whole."""
    stop = {"edges": ["hinge", "latch", "top", "bottom"], "clearance": 0.0005}
    half, whole = (
        shape([-0.8, 0.0, 0.8], opens=opens, stop=stop, hinge_play=0.001, lock_play=0.002, symmetry=s)
        for s in ("quarter", "none")
    )
    side = 1.0 if opens == "towards_fire" else -1.0
    for one in (half, whole):
        assert max((side * out).max() for out in one.edge_moved.values()) < 0.0005 + 1e-9
        pushes = [r.force for r in one.support_forces if r.points is not None]
        assert all(side * f <= 0.0 for f in pushes) and max(map(abs, pushes)) > 100.0
        assert sum(r.force for r in one.support_forces) == pytest.approx(0.0, abs=0.01)
    assert half.bow == pytest.approx(whole.bow, rel=1e-6)
    for a, b in zip(half.support_forces, whole.support_forces, strict=True):
        assert a.name == b.name and a.points == b.points
        assert a.force == pytest.approx(b.force, abs=0.01)
    assert half.gap < 0.9 * shape([-0.8, 0.0, 0.8]).gap or opens == "away_from_fire"


def test_several_locks_close_the_free_corners():
    """A bolt at each corner of the latch edge keeps it nearer to the frame than one in the middle."""
    one, three = (shape([-0.8, 0.8], lock=lock) for lock in (0.0, [-0.9, 0.0, 0.9]))
    assert three.edge_gap["right"] < 0.3 * one.edge_gap["right"]
    top = shape([-0.8, 0.8], lock=[{"height": 1.0, "across": 0.5}, {"height": -1.0, "across": 0.5}])
    assert top.edge_moved["right"][0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("deformation", "said"),
    [
        ({"lock": None, "opens": "away_from_fire"}, "the frame's stop holds one way only: a mechanism"),
        ({"lock": [], "hinge_play": 0.001}, "a mechanism has no shape"),
        ({"lock": {"height": 0.0, "across": -0.5}}, "free to turn about the line"),
        ({"hinges": [{"height": 1.2}, 0.0]}, "hinges: has 1.2, off the leaf"),
        ({"lock": [{"height": 0.0, "across": 0.7}]}, "lock: has 0.7, off the leaf"),
        ({"hinge_play": 3.0}, "metres, not millimetres"),
        ({"hinges": [{"height": 0.8, "stiffness": 100.0}, -0.8]}, "newtons per metre"),
        ({"stop": {"edges": ["top"]}}, "is on no side; give opens"),
        (
            {"opens": "towards_fire", "stop": {"edges": ["top", "top"]}},
            r"edges\.1: is 'top' like deformation\.stop\.edges\.0",
        ),
        ({"hinge_line": 0.6}, "at most 0.2 m"),
        (
            {"hinges": [0.8, -0.8, 0.8]},
            r"hinges\.2: is at 0\.8 m like deformation\.hinges\.0; give each hinge",
        ),
        (
            {"lock": [{"height": 0.1, "across": 0.5, "play": 0.001}, 0.1]},
            r"lock\.1: is at 0\.1 m, 0\.5 m across like deformation\.lock\.0; give each lock",
        ),
        ({"hinges": ["top", 0.0]}, r"hinges\.0: is 'top'; give a height in m"),
    ],
)
def test_supports_that_cant_be_are_refused(deformation, said):
    with pytest.raises(SceneError, match=said):
        load_scene(door(deformation={"model": "shell", **deformation}), WOOL)


def test_a_hinge_line_within_the_leaf_is_where_it_is_held():
    inside = shape([-0.8, 0.8], hinge_line=0.1, in_plane=[10, 20])
    assert abs(inside.edge_moved["left"][4]) > 1e-4  # the edge itself is free now
