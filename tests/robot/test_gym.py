"""Environments for learning: Gymnasium's own checks, and episodes that are the same for the same seed."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from scenes import link, robot, two_link

from flexsim_node import load_scene, simulate
from flexsim_node.gym import FlexibleArm, FlexibleArms, Reach, Servo, Settle, Track

TORQUE = np.array([1.0, 0.3])
SERVO = Servo(stiffness=np.array([20.0, 5.0]), damping=np.array([1.0, 0.2]), speed=1.0)


def arm(task=None, scene=None, **keys):
    given = {"control_period": 0.01, "duration": 0.1, "torque": None if "servo" in keys else TORQUE, **keys}
    return FlexibleArm(scene or load_scene(two_link(gravity=[0.0, 0.0, 0.0])), task or Settle(), **given)


def played(env, seed, actions):
    """What is seen, rewards and ends of an episode."""
    seen = [env.reset(seed=seed)[0]]
    rewards, ends = [], []
    for action in actions:
        now, reward, failed, over, _ = env.step(action)
        seen.append(now)
        rewards.append(reward)
        ends.append((failed, over))
    return np.array(seen), np.array(rewards), ends


@pytest.mark.parametrize("task", [Reach(), Settle(), Track()], ids=["reach", "settle", "track"])
@pytest.mark.parametrize("keys", [{}, {"servo": SERVO}], ids=["torque", "servo"])
def test_gymnasiums_own_checks(task, keys):
    """check_env finds nothing, not even to warn of, but that readings have no bounds."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*space m[a-z]+ value is -?infinity")
        check_env(arm(task, **keys), skip_render_check=True)


def test_the_same_seed_is_the_same_episode():
    """To the last bit, in a used environment as in a new one, with draws and noise; others differ."""
    scene = load_scene(
        two_link(faults=[{"kind": "noise", "signal": "position", "deviation": 1e-3}], gravity=[0.0, 0.0, 0.0])
    )
    randomize = {"links.1.payload": lambda rng: {"mass": rng.uniform(0.0, 0.2)}, "seed": True}
    actions = np.random.default_rng(5).uniform(-1.0, 1.0, (10, 2))
    env = arm(Reach(), scene, randomize=randomize)
    first = played(env, 7, actions)
    other = played(env, 8, actions)
    again = played(env, 7, actions)
    fresh = played(arm(Reach(), scene, randomize=randomize), 7, actions)
    for one in (again, fresh):
        np.testing.assert_array_equal(one[0], first[0])
        np.testing.assert_array_equal(one[1], first[1])
    assert not np.array_equal(first[0], other[0])
    assert first[2] == [(False, False)] * 9 + [(False, True)]


def test_an_episode_is_the_robots_own_motion():
    """Held torques move it as simulate does; rewards are those of its tip."""
    scene = load_scene(two_link(gravity=[0.0, 0.0, 0.0]))
    actions = np.random.default_rng(2).uniform(-1.0, 1.0, (10, 2))
    task = Reach(spread=0.5)
    seen, rewards, _ = played(arm(task, scene), 0, actions)
    run = simulate(scene, actions * TORQUE, duration=0.1, sample_period=0.01)
    np.testing.assert_array_equal(seen[:, :2], run.joint_position)
    np.testing.assert_array_equal(seen[:, 2:4], run.joint_velocity)
    away = np.linalg.norm(run.link_end[1:, 1] - task.goal, axis=1)
    np.testing.assert_allclose(rewards, -away, rtol=1e-12)  # the reach is 1 m


def test_a_servo_holds_and_follows():
    """Without an action the joints stay; an action of 1 turns them at the servo's speed."""
    scene = load_scene(two_link(gravity=[0.0, 0.0, 0.0]))
    env = arm(Track(), scene, servo=SERVO, duration=1.0)
    seen, _, _ = played(env, 0, np.zeros((20, 2)))
    assert np.max(np.abs(seen[:, :4])) == 0.0
    seen, _, _ = played(env, 0, np.tile([1.0, 0.0], (100, 1)))
    assert seen[-1, 0] == pytest.approx(1.0, abs=0.15)
    assert abs(seen[-1, 1]) < 0.2


def test_many_robots_are_as_many_single_ones():
    """Robot k of a seed is the single one of the seed plus k; after an end the next step begins anew."""
    scene = load_scene(two_link(gravity=[0.0, 0.0, 0.0]))
    keys = {"control_period": 0.01, "duration": 0.05, "torque": TORQUE}
    many = FlexibleArms(scene, Settle(), 3, **keys)
    assert isinstance(many, gymnasium.vector.VectorEnv)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (7, 3, 2))
    seen = [many.reset(seed=4)[0]]
    rewards, cuts = [], []
    for action in actions:
        now, reward, ended, cut, told = many.step(action)
        seen.append(now)
        rewards.append(reward)
        cuts.append(cut)
        assert not ended.any() and not told
    for k in range(3):
        single = FlexibleArm(scene, Settle(), **keys)
        own_seen, own_rewards, _ = played(single, 4 + k, actions[:5, k])
        np.testing.assert_array_equal(np.array(seen)[:6, k], own_seen)
        np.testing.assert_array_equal(np.array(rewards)[:5, k], own_rewards)
        np.testing.assert_array_equal(np.array(seen)[6, k], single.reset()[0])
    assert [bool(c.all()) for c in cuts] == [False] * 4 + [True] + [False] * 2
    assert np.all(np.array(rewards)[5] == 0.0)


def test_sensors_are_seen():
    """A gauge's reading is behind what the joints and the task show."""
    scene = load_scene(
        two_link(
            sensors=[{"name": "gauge", "type": "strain_gauge", "link": "link_1", "at": 0.05, "side": "+y"}]
        )
    )
    env = arm(Settle(), scene, sensors=("gauge",))
    seen, _, _ = played(env, 0, np.zeros((3, 2)))
    assert seen.shape[1] == 5
    assert np.all(seen[1:, 4] != 0.0)


def test_a_robot_that_can_not_go_on_ends_the_episode():
    """It is terminated, loses a fixed amount, and says why."""
    env = arm(torque=np.array([1e9, 0.0]))
    env.reset(seed=0)
    for _ in range(10):
        seen, reward, failed, over, info = env.step(np.array([1.0, 0.0]))
        assert np.all(np.isfinite(seen))
        if failed:
            break
    assert failed and not over and reward == -10.0
    assert info["reason"]


def test_what_cannot_be_is_refused():
    """Each with what would be right."""
    scene = load_scene(two_link())
    refused = [
        ({"torque": None}, "what torque is an action of 1"),
        ({"torque": np.ones(3)}, "what torque is an action of 1"),
        ({"torque": TORQUE, "servo": SERVO}, "both given"),
        ({"servo": Servo(np.ones(3), np.ones(2))}, "give a value for each of link_1_joint, link_2_joint"),
        ({"sensors": ("eye",)}, "no sensor 'eye'"),
        ({"control_period": 0.0}, "give seconds"),
        ({"render_mode": "human"}, "give 'rerun'"),
        ({"randomize": {"links.1.payload.mass": (-2.0, -1.0)}}, "links.1.payload.mass"),
    ]
    for keys, said in refused:
        with pytest.raises(ValueError, match=said):
            FlexibleArm(scene, Settle(), **{"torque": None if "servo" in keys else TORQUE, **keys})
    env = arm()
    env.reset(seed=0)
    for action in (np.array([np.nan, 0.0]), np.zeros(3)):
        with pytest.raises(ValueError, match="give 2 finite values"):
            env.step(action)
    forked = load_scene(
        robot(link("a", {"a": 0.5}), link("b", {"a": 0.4}), link("c", {"a": 0.3}, parent="a"))
    )
    with pytest.raises(ValueError, match="2 tips"):
        FlexibleArm(forked, Settle(), torque=np.ones(3)).reset(seed=0)
