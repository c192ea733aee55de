"""The standard for simulators (simulation_interfaces), by a client's eyes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from robot_process import SCENE, robot
from simulation_interfaces.msg import (
    Bounds,
    EntityCategory,
    EntityFilters,
    Result,
    SimulationState,
    SimulatorFeatures,
    TagsFilter,
)
from simulation_interfaces.srv import ResetSimulation, SetSimulationState
from simulator import Client

from flexsim_node import load_scene, simulate

pytestmark = pytest.mark.ros
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
OK, FAILED = Result.RESULT_OK, Result.RESULT_OPERATION_FAILED
START = [0.3, 0.8, -0.6]


def test_pause_step_reset_stop_play(tmp_path: Path) -> None:
    """Every transition has the standard's code; steps are control periods; a reset is the first state."""
    codes = SetSimulationState.Response
    with robot(tmp_path, rate=500.0, override__initial__position=START) as arm:
        arm.connected()
        client = Client(arm)
        features = set(client.call("GetSimulatorFeatures").features.features)
        assert {SimulatorFeatures.STEP_SIMULATION_ACTION, SimulatorFeatures.SIMULATION_RESET_TIME} < features
        assert client.state() == PLAYING
        assert client.set_state(PLAYING) == codes.ALREADY_IN_TARGET_STATE
        refused = client.call("StepSimulation", steps=1).result
        assert refused.result == FAILED
        assert "pause it" in refused.error_message
        assert client.set_state(PAUSED) == OK
        assert client.state() == PAUSED
        arm.until(lambda: arm.diagnostics().get("phase") == "paused")
        before = arm.time()
        assert client.call("StepSimulation", steps=5).result.result == OK
        arm.until(lambda: arm.time() == pytest.approx(before + 5 * 2e-3, abs=1e-9))
        assert client.call("StepSimulation", steps=0).result.result == OK

        # time goes on over a reset of the state, and begins anew with a reset of all
        only_state = ResetSimulation.Request.SCOPE_STATE
        assert client.call("ResetSimulation", scope=only_state).result.result == OK
        arm.until(lambda: np.allclose(arm.states()[-1].position, START, rtol=0, atol=0))
        assert arm.time() == pytest.approx(before + 5 * 2e-3, abs=1e-9)
        assert client.call("ResetSimulation").result.result == OK
        arm.until(lambda: arm.time() == 1e-9)
        assert client.call("ResetSimulation", scope=8).result.result == Result.RESULT_FEATURE_UNSUPPORTED

        # the same motion as offline, by the service and by the action with its feedback
        offline = simulate(load_scene(SCENE, {"initial.position": START}), None, 0.02, 2e-3)
        assert client.call("StepSimulation", steps=10).result.result == OK
        arm.until(lambda: arm.time() == pytest.approx(0.02, abs=1e-9))
        np.testing.assert_allclose(arm.states()[-1].position, offline.joint_position[-1], rtol=0, atol=1e-9)
        status, result, heard = client.simulate_steps(500)  # a client hears feedback once it knows its goal
        assert (status, result.result) == (GoalStatus.STATUS_SUCCEEDED, OK)
        assert heard == sorted(heard)
        assert 0 < heard[-1] <= 500
        arm.until(lambda: arm.time() == pytest.approx(0.02 + 500 * 2e-3, abs=1e-9))
        status, _, heard = client.simulate_steps(2**63, cancel_after=3)
        assert status == GoalStatus.STATUS_CANCELED
        assert client.state() == PAUSED

        assert client.set_state(STOPPED) == OK
        arm.until(lambda: arm.time() == 1e-9)
        assert client.set_state(PAUSED) == codes.INCORRECT_TRANSITION
        assert client.set_state(SimulationState.STATE_LOADING_WORLD) == Result.RESULT_FEATURE_UNSUPPORTED
        assert client.set_state(PLAYING) == OK
        status, result, _ = client.simulate_steps(1)
        assert (status, result.result) == (GoalStatus.STATUS_ABORTED, FAILED)
        arm.until(lambda: arm.time() > 0.1)
        entities_of_a_robot(arm, client)
        parameters_that_may_change(arm)


def entities_of_a_robot(arm, client: Client) -> None:
    """The robot and its links, by name, category and tag; a state that agrees with the topic."""
    links = [f"anthropomorphic/link_{k}" for k in (1, 2, 3)]
    found = client.call("GetEntities")
    assert found.result.result == OK
    assert list(found.entities) == ["anthropomorphic", *links]

    def names(**filters: object) -> list[str]:
        return list(client.call("GetEntities", filters=EntityFilters(**filters)).entities)

    assert names(filter="[[:alpha:]]+/link_[23]") == links[1:]
    assert names(categories=[EntityCategory(category=EntityCategory.CATEGORY_OBJECT)]) == []
    assert names(tags=TagsFilter(tags=["link", "flexible"], filter_mode=1)) == links
    refused = client.call("GetEntities", filters=EntityFilters(filter="(")).result
    assert refused.result == FAILED
    assert "not closed" in refused.error_message
    box = EntityFilters(bounds=Bounds(type=Bounds.TYPE_BOX))
    assert client.call("GetEntities", filters=box).result.result == Result.RESULT_FEATURE_UNSUPPORTED
    info = client.call("GetEntityInfo", entity=links[0]).info
    assert info.category.category == EntityCategory.CATEGORY_ROBOT
    nobody = client.call("GetEntityState", entity="nobody").result
    assert nobody.result == Result.RESULT_NOT_FOUND
    assert "link_1" in nobody.error_message

    assert client.set_state(PAUSED) == OK
    state = client.call("GetEntityState", entity=links[2]).state
    shapes = arm.heard["flexsim_node/elastic_state"]
    shapes.clear()  # the last one is repeated
    shape = arm.until(lambda: next((m for m in shapes if m.header.stamp == state.header.stamp), None))
    p, o = state.pose.position, state.pose.orientation
    np.testing.assert_allclose([p.x, p.y, p.z], np.reshape(shape.position, (-1, 3))[-1], rtol=0, atol=1e-12)
    assert math.hypot(o.x, o.y, o.z, o.w) == pytest.approx(1.0)
    assert len(client.call("GetEntitiesStates").states) == 4
    v = state.twist.linear
    before = np.array([p.x, p.y, p.z])
    client.call("StepSimulation", steps=1)
    after = client.call("GetEntityState", entity=links[2]).state
    p, w = after.pose.position, after.twist.linear
    moved = (np.array([p.x, p.y, p.z]) - before) / 2e-3
    mean = 0.5 * np.array([v.x + w.x, v.y + w.y, v.z + w.z])  # however fast it falls by now
    np.testing.assert_allclose(moved, mean, atol=0.02)
    assert client.set_state(PLAYING) == OK


def parameters_that_may_change(arm) -> None:
    """Rates may, the scene may not, and nothing changes where one of several is refused."""
    client = arm.node.create_client(SetParameters, "flexsim_node/set_parameters")
    arm.until(client.service_is_ready)

    def put(name: str, value: object) -> tuple[bool, str]:
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        future = client.call_async(request)
        (answer,) = arm.until(lambda: future.done() and future.result()).results
        return answer.successful, answer.reason

    assert put("elastic_rate", 100.0) == (True, "")
    assert put("command_timeout", 0.5) == (True, "")
    good, reason = put("scene", "elsewhere.yaml")
    assert not good
    assert "read-only parameter: scene" in reason
    assert put("command_timeout", 1) == (True, "")  # a whole number is one
    for name, value, right in (
        ("elastic_rate", float("nan"), "give Hz"),
        ("elastic_rate", 333.0, "333.333 Hz"),
        ("command_timeout", -1.0, "0.0 for never"),
    ):
        good, reason = put(name, value)
        assert not good
        assert right in reason
    since = arm.time()
    arm.heard["flexsim_node/elastic_state"].clear()
    arm.until(lambda: arm.time() > since + 0.2)
    stamps = np.array([m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec
                       for m in arm.heard["flexsim_node/elastic_state"]])  # fmt: skip
    np.testing.assert_allclose(np.diff(stamps)[2:], 0.01, atol=1e-9)


def test_quit_ends_the_process(tmp_path: Path) -> None:
    """QUITTING is answered, then the node ends with code 0, as after Ctrl-C."""
    with robot(tmp_path, mode="lockstep") as arm:
        arm.connected()
        assert Client(arm).set_state(QUITTING) == OK
        assert arm.process.process.wait(20) == 0
