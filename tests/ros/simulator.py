"""The standard's services of a running simulator, as a client calls them."""

from __future__ import annotations

from typing import Any

from rclpy.action import ActionClient
from robot_process import Robot
from simulation_interfaces import srv
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import SimulationState


class Client:
    """Calls services of one node, by type."""

    def __init__(self, robot: Robot, node: str = "flexsim_node") -> None:
        self.robot, self.name = robot, node
        self.clients: dict[str, Any] = {}
        self.action = ActionClient(robot.node, SimulateSteps, f"{node}/simulate_steps")

    def call(self, kind: str, request: Any = None, **fields: Any) -> Any:
        """Call e.g. `StepSimulation` and return the response."""
        service = getattr(srv, kind)
        if kind not in self.clients:
            name = "".join(f"_{c.lower()}" if c.isupper() else c for c in kind)[1:]
            self.clients[kind] = self.robot.node.create_client(service, f"{self.name}/{name}")
        client = self.clients[kind]
        self.robot.until(client.service_is_ready)
        future = client.call_async(request or service.Request(**fields))
        return self.robot.until(lambda: future.done() and future.result())

    def set_state(self, state: int) -> int:
        """Ask for a state of the simulation; returns the result's code."""
        wanted = SimulationState(state=state)
        return int(self.call("SetSimulationState", state=wanted).result.result)

    def state(self) -> int:
        """Return the state of the simulation."""
        return int(self.call("GetSimulationState").state.state)

    def simulate_steps(self, steps: int, cancel_after: int = 0) -> tuple[int, Any, list[int]]:
        """Send a goal; returns its status, its result and the steps done in each feedback."""
        heard: list[int] = []
        self.robot.until(self.action.server_is_ready)
        sent = self.action.send_goal_async(
            SimulateSteps.Goal(steps=steps),
            feedback_callback=lambda m: heard.append(m.feedback.completed_steps),
        )
        goal = self.robot.until(lambda: sent.done() and sent.result())
        assert goal.accepted
        if cancel_after:
            self.robot.until(lambda: len(heard) >= cancel_after)
            goal.cancel_goal_async()
        waited = goal.get_result_async()
        done = self.robot.until(lambda: waited.done() and waited.result())
        return done.status, done.result.result, heard
