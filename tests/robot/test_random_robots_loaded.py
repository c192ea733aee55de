"""What loads do to the stiffness of robots that nobody thought of, to the first order of load over stiffness.

Weight turns with the ends that it rides on, presses, pulls, bends and twists the beams below; spin pulls at
all.  Each robot comes from a seed (random_robots.py).
"""

from __future__ import annotations

import copy

import numpy as np
import pytest
from loaded_frame import LoadedFrame
from random_robots import random_robot
from robot_images import cut, straightened, turned, with_twice_the_elements
from test_random_robots import FORMULATIONS, seeds

from flexsim_node import load_scene, natural_frequencies, static_equilibrium

LOWEST = 4


def finely(made, count: int = 4):
    """The robot with so many elements a link, nothing left out of its inertia."""
    made = copy.deepcopy(made)
    for part in made["links"]:
        if "beam" in part:
            part["beam"]["elements"] = count
    return made


def squares(scene, **keys) -> np.ndarray:
    """The lowest squared angular frequencies, 1/s2."""
    found = natural_frequencies(scene, scene.start("position"), **keys)
    return (2 * np.pi * found[:LOWEST]) ** 2


def bends(made) -> bool:
    """Whether anything gives way."""
    return any("beam" in part and part.get("flexible", True) for part in made["links"])


def small_load(scene) -> float:
    """The share of its weight that turns the robot's sections by 1e-3 rad."""
    # the same whatever the formulation leaves out: from the stiffness of the unloaded robot
    shape = static_equilibrium(scene.model_copy(update={"formulation": "co_moving"}), scene.start("position"))
    turn = float(np.max(np.abs(shape.node_displacement[:, 3:])))
    return 1e-3 / max(turn, 1e-5)


@seeds("serial", "branched", few=2)
def test_weight_changes_frequencies_as_a_frame_says(kind, seed):
    """How fast each squared frequency changes with the weight, by a corotational frame's potential."""
    made = finely(random_robot(seed, kind), 3)
    if not bends(made):
        pytest.skip("nothing bends")
    scene = load_scene(made)
    share = small_load(scene)
    frame = LoadedFrame(scene, scene.start("position"))
    ways = [frame.squared(sign * share)[:LOWEST] for sign in (1.0, -1.0)]
    right = (ways[0] - ways[1]) / (ways[0] + ways[1])
    for formulation in FORMULATIONS:
        found = []
        for sign in (1.0, -1.0):
            gravity = [sign * share * g for g in scene.gravity]
            loaded = load_scene(made, {"gravity": gravity, "formulation": formulation})
            found.append(squares(loaded, loaded=True))
        change = (found[0] - found[1]) / (found[0] + found[1])
        assert np.allclose(change, right[: len(change)], rtol=0, atol=0.03 * np.max(np.abs(right)) + 1e-8)


@seeds("serial", "branched", "closed", few=4)
def test_weight_changes_frequencies_alike(kind, seed):
    """Under its weight the ERLS' frequencies are co-moving frames' to the squares of what weight changes and
    of the elastic rotation.
    """
    made = finely(random_robot(seed, kind, modulus=2e10), 2)
    if not bends(made):
        pytest.skip("nothing bends")
    one, two = (load_scene(made, {"formulation": f}) for f in FORMULATIONS)
    free = squares(one)
    try:
        right = squares(two, loaded=True)
    except ArithmeticError:
        pytest.skip("too soft to stand")
    change = np.max(np.abs(right / free - 1.0))
    if change > 0.3:
        pytest.skip("too soft for a first order")
    shape = static_equilibrium(one, one.start("position"))
    turned = np.max(np.abs(shape.node_displacement[:, 3:]))
    # two elements a link carry what loads change to 3 %
    within = 0.03 * change + 2.0 * change**2 + 3.0 * turned**2 + 1e-5
    assert np.allclose(squares(one, loaded=True) / free, right / free, rtol=0, atol=within)


@seeds("serial", "branched", few=4)
def test_spin_changes_frequencies_alike(kind, seed):
    """Spun, the ERLS' frequencies are co-moving frames' to the square of what spin changes."""
    made = finely(random_robot(seed, kind, modulus=2e10, gravity=[0.0, 0.0, 0.0]), 2)
    turning = [
        part["joint"]["type"] == "revolute" for part in made["links"] if part["joint"]["type"] != "fixed"
    ]
    if not bends(made) or not turning[0]:
        pytest.skip("nothing bends, or nothing spins")
    scenes = [load_scene(made, {"formulation": f}) for f in FORMULATIONS]
    free = squares(scenes[0])
    spin = np.zeros(len(turning))
    spin[0] = 0.15 * np.sqrt(free[0])
    one, right = (squares(scene, velocity=spin) / free for scene in scenes)
    change = np.max(np.abs(right - 1.0))
    assert np.allclose(one, right, rtol=0, atol=2.0 * change**2 + 1e-5)


@seeds("serial", "branched", few=4)
def test_rigid_link_is_a_very_stiff_one(kind, seed):
    """A link that is said to be rigid, or given a modulus of 1e14: the same loaded frequencies to 0.1 %."""
    made = random_robot(seed, kind, modulus=2e10)
    beams = [part for part in made["links"] if "beam" in part and part.get("flexible", True)]
    if len(beams) < 2:
        pytest.skip("fewer than two links bend")
    stiff = copy.deepcopy(made)
    name = beams[-1]["name"]
    beams[-1]["flexible"] = False
    next(part for part in stiff["links"] if part["name"] == name)["beam"]["youngs_modulus"] = 1e14
    try:
        right = squares(load_scene(stiff), loaded=True)
    except ArithmeticError:
        pytest.skip("too soft to stand")
    found = squares(load_scene(made), loaded=True)
    assert np.allclose(np.sqrt(found), np.sqrt(right[: len(found)]), rtol=1e-3)


@seeds("serial", "branched")
def test_loaded_robot_described_otherwise(kind, seed):
    """Turned with its gravity, or its links in two pieces: the same loaded frequencies."""
    made = straightened(random_robot(seed, kind))
    whole = with_twice_the_elements(made)
    for formulation in FORMULATIONS:
        found = []
        for same in (whole, cut(made), turned(whole, 0.7, -1.1)):
            scene = load_scene(same, {"formulation": formulation})
            try:
                found.append(squares(scene, loaded=True))
            except ArithmeticError:
                found.append(np.zeros(LOWEST))
        assert np.allclose(found[1], found[0], rtol=1e-5)
        assert np.allclose(found[2], found[0], rtol=1e-5)


def test_the_frame_buckles_sideways_where_timoshenko_says():
    """The frame itself: a deep strip's frequency is gone at 4.0126 sqrt(EI GJ) / L2 of weight at its end."""
    from flexsim_node.elements.section import torsion_constant

    high, thin, length = 0.04, 0.001, 0.6
    critical = (
        4.0126 * np.sqrt(2e11 * high * thin**3 / 12 * 2e11 / 2.6 * torsion_constant(high, thin)) / length**2
    )
    beam = {"width": high, "depth": thin, "density": 10.001, "youngs_modulus": 2e11, "elements": 8}
    scene = load_scene(
        {
            "model": "robot",
            "name": "strip",
            "gravity": [0.0, -1.0, 0.0],
            "links": [{"name": "a", "dh": {"a": length}, "beam": beam, "payload": {"mass": critical}}],
        }
    )
    frame = LoadedFrame(scene, [0.0])
    assert frame.squared(0.97)[0] > 0.0 > frame.squared(1.03)[0]
