"""Where a robot's tips are: what the user says, else the free ends that move."""

import numpy as np
import pytest
from scenes import link, robot, two_link

from flexsim_node import SceneError, load_scene, resolve_effects

BRACKET = {"name": "bracket", "parent": "base", "dh": {"a": 0.3}, "joint": {"type": "fixed"}}


def arm(*more, **keys):
    """One flexible link that falls, with a payload."""
    rod = link("arm", {"a": 1.0}, 0.005, 0.02, payload={"mass": 1.0})
    return robot(rod, *more, gravity=[0.0, -9.81, 0.0], **keys)


def names(scene):
    return [scene.link_names[n] for n in scene.tips]


def test_the_free_ends_that_move():
    """A camera bracket on the base is no tip wherever it stands; two arms have two."""
    assert names(load_scene(two_link())) == ["link_2"]
    assert names(load_scene(arm(BRACKET))) == ["arm"]
    hand = {"name": "hand", "parent": "arm", "dh": {"a": 0.1}, "joint": {"type": "fixed"}}
    other = link("other", {"a": 0.4}, parent="base")
    assert names(load_scene(arm(hand, other))) == ["hand", "other"]
    assert names(load_scene(arm(BRACKET, tip="bracket"))) == ["bracket"]
    assert names(load_scene(arm(hand, other, tip=["arm", "other"]))) == ["arm", "other"]


def test_loops_close_ends():
    """In a four-bar every end is held: those of the tree's last links count."""
    from scenes import CONFIG

    scene = load_scene(CONFIG / "four_bar.yaml")
    tips = names(scene)
    assert tips
    assert all(scene.link_names.index(n) not in scene.parents for n in tips)


@pytest.mark.parametrize(
    ("tip", "said"),
    [
        ("hand", "tip: is 'hand', which does not exist"),
        ("arm/camera", "arm has no points: give arm, whose end is meant"),
        (["arm", "arm"], "tip.1: is 'arm' like tip.0"),
        ([], "tip"),
    ],
)
def test_mistakes(tip, said):
    with pytest.raises(SceneError, match=said):
        load_scene(arm(tip=tip))


def test_effects_are_judged_at_the_tips():
    """With a bracket last in `links`, gravity stays: without it the arm would hang in the air."""
    scene = load_scene(arm(BRACKET, effects="auto", tolerance=1e-5, duration=0.1))
    found = resolve_effects(scene)
    assert found.scene.effects.gravity is True
    gravity = next(c for c in found.changes if c.name == "gravity")
    assert gravity.change > 0.01
    assert np.isfinite(gravity.change)
