"""The rig: one flexsim_node in lockstep, a controller process for each run, and what the robot did."""

from __future__ import annotations

import os
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from flexsim_node import Scene

from ..controller.laws import LAWS
from ..controller.trajectory import Trajectory
from ..ros.context import tool_node
from ..ros.simulator import SimulatorWatch
from ..terminal.stop import Stop
from ..trial.patience import Patience
from ..trial.processes import NODE, Failed, Process, Processes, own_domain, processes
from .cases import Case
from .score import Recording

STARTED, ANSWERED = 240.0, 30.0
# s after which a question is asked again: an answer to one who is not known yet is lost
AGAIN = 5.0
# s without an answer: that a controller may do nothing, that it may compute, once it has answered before, and
# that it may do nothing when the robot has refused what it sent.
IDLE, LONGEST, REFUSED = 10.0, 120.0, 2.0
SPIN = 0.01  # s that answers are waited for before states are looked for
LOOK = 0.2  # the most, s, that a wait grows by from look to look
STOPPED, PLAYING = 0, 1
OK, ALREADY = 1, 101  # simulation_interfaces: done, and it was so before


class Rig:
    """Runs cases; the robot's process stays, its state and faults are set for each."""

    def __init__(
        self, node: Any, ears: Any, trial: Processes, scene: Path, overrides: Mapping[str, Any], rate: float
    ) -> None:
        from flexsim_msgs.msg import ElasticState
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState
        from trajectory_msgs.msg import JointTrajectory

        self.node, self.trial, self.scene, self.overrides, self.rate = node, trial, scene, overrides, rate
        self.executor = SingleThreadedExecutor(context=node.context)
        self.executor.add_node(node)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.trajectories = node.create_publisher(JointTrajectory, "joint_trajectory", latched)
        deep = QoSProfile(depth=5000)
        self.states: list[Any] = []
        self.shapes: list[Any] = []
        # Polled, which costs a tenth of an executor's callbacks: the rig must not lag behind its robot.
        self.heard = [
            (kind, self.taken(run), ears.create_subscription(kind, topic, lambda _: None, deep))
            for kind, topic, run in (
                (JointState, "joint_states", self.states),
                (ElasticState, "flexsim_node/elastic_state", self.shapes),
            )
        ]
        self.parameters = [
            "--ros-args", "-p", f"scene:={scene}",
            *(w for key, value in overrides.items() for w in ("-p", f"override.{key}:={value}")),
        ]  # fmt: skip
        rates = [word for name in ("rate", "elastic_rate", "shape_rate", "clock_rate")
                 for word in ("-p", f"{name}:={rate}")]  # fmt: skip
        words = [*NODE, *self.parameters, *rates, "-p", "mode:=lockstep"]
        self.robot = trial.start("flexsim_node", words)
        self.watch = SimulatorWatch(ears, "flexsim_node", self.robot.process)
        trial.wait_until_said(self.robot, "kernels ready", timeout=STARTED)

    def begins(self, message: Any) -> bool:
        """Say whether a message is the first of a run: time begins anew with a reset."""
        return stamp(message) < 0.5 / self.rate

    def taken(self, run: list[Any]) -> Callable[[Any], None]:
        """Return what takes the messages of a run, and not those that are on their way from the last one."""

        def take(message: Any) -> None:
            if self.begins(message):
                run.clear()
            run.append(message)

        return take

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """Call a service of the robot, which may be asked more than once."""
        client = self.node.create_client(kind, f"flexsim_node/{name}")
        asked: list[Any] = []

        def answer() -> Any:
            if time.monotonic() > begun + AGAIN * len(asked):
                asked.append(client.call_async(request))
            return next((future.result() for future in asked if future.done()), None)

        try:
            self.until(client.service_is_ready, ANSWERED, f"no service {name}")
            begun = time.monotonic()
            return self.until(answer, ANSWERED, f"{name}: no answer")
        finally:
            self.node.destroy_client(client)

    def hear(self) -> int:
        """Take what has come, and wait a moment for answers; how many states and shapes there were."""
        self.executor.spin_once(timeout_sec=SPIN)
        self.watch.poll()
        count = 0
        for kind, take, subscription in self.heard:
            with subscription.handle:
                while (taken := subscription.handle.take_message(kind, False)) is not None:
                    take(taken[0])
                    count += 1
        return count

    def until(self, condition: Callable[[], Any], timeout: float, failure: str) -> Any:
        """Hear until something is true.

        Time counts in which nothing came, and by looks: a rig that is held up itself is no reason to give up.
        """
        waited, since = 0.0, time.monotonic()
        while not (found := condition()):
            self.trial.check()
            if waited > timeout:
                raise TimeoutError(failure)
            came = self.hear()
            now = time.monotonic()
            waited += 0.0 if came else min(now - since, LOOK)
            since = now
        return found

    def set_state(self, state: int) -> None:
        """Play or stop the simulation."""
        from simulation_interfaces.msg import SimulationState
        from simulation_interfaces.srv import SetSimulationState

        wanted = SetSimulationState.Request(state=SimulationState(state=state))
        done = self.call(SetSimulationState, "set_simulation_state", wanted).result
        if done.result not in (OK, ALREADY):
            raise RuntimeError(f"flexsim_node does not take state {state}: {done.error_message}")

    def reset(self) -> None:
        """Return the robot to its first state, at time zero."""
        from simulation_interfaces.srv import ResetSimulation

        self.call(ResetSimulation, "reset_simulation", ResetSimulation.Request())

    def trouble(self) -> str:
        """Why the robot's time stands still, or nothing."""
        from simulation_interfaces.srv import GetSimulationState

        request = GetSimulationState.Request()
        return str(self.call(GetSimulationState, "get_simulation_state", request).result.error_message)

    def set_faults(self, case: Case) -> None:
        """Take a case's faults beside the scene's own."""
        import json

        from rcl_interfaces.srv import SetParameters
        from rclpy.parameter import Parameter

        own = [fault.model_dump(exclude_none=True) for fault in self.loaded.faults]
        text = json.dumps([*own, *case.faults])
        asked = [Parameter("faults", value=text).to_parameter_msg()]
        (done,) = self.call(SetParameters, "set_parameters", SetParameters.Request(parameters=asked)).results
        if not done.successful:
            raise RuntimeError(f"case {case.name}: {done.reason}")

    def run(self, controller: str, case: Case, wanted: Trajectory, until: float, scene: Scene) -> Recording:
        """Run one case with a fresh controller process; one that has no end is lost, with the reason."""
        self.loaded = scene
        self.set_state(STOPPED)
        self.set_faults(case)
        self.trajectories.publish(message(wanted, scene))
        name = f"{Path(shlex.split(controller)[0]).stem}_{len(self.trial.running)}"
        process = self.trial.start(name, [*command(controller), *self.parameters, "-p", f"rate:={self.rate}"])
        failed = False
        try:
            trouble = self.drive(process, until)
        except Failed as problem:
            if problem.process is not process:
                raise
            trouble, failed = str(problem), True
        self.trial.dismiss(process)
        if failed:  # a robot that has stopped is a reason for its controller to end
            trouble = self.trouble() or trouble
        found = recorded(self.states, self.shapes, until, trouble, self.rate)
        self.set_state(STOPPED)  # which begins anew
        return found

    def drive(self, process: Process, until: float) -> str:
        """Let a controller drive the robot from its first state on; why the run had no end, or nothing."""
        self.states.clear()
        self.shapes.clear()
        self.watch.status = None
        self.reset()
        runs = self.states, self.shapes
        self.until(
            lambda: self.watch.status and all(run and self.begins(run[0]) for run in runs),
            ANSWERED,
            "no state after a reset",
        )
        if trouble := self.trouble():
            return trouble
        self.set_state(PLAYING)
        patience = Patience(process.pid, IDLE, STARTED)
        refused = self.watch.status.refused if self.watch.status else 0
        reached = stamp(self.states[-1]), stamp(self.shapes[-1])
        while min(stamp(run[-1]) for run in runs) < until - 1e-9:
            self.trial.check()
            self.hear()
            if self.watch.gone:
                raise RuntimeError(self.watch.gone)
            # What was said before the reset may have come after it, so the robot is asked.
            if self.watch.trouble and (trouble := self.trouble()):
                return trouble
            now = stamp(self.states[-1]), stamp(self.shapes[-1])
            status = self.watch.status
            if now != reached:  # a state that is repeated is no sign of life
                reached = now
                patience.restart(IDLE, LONGEST)
                refused = status.refused if status else 0
            elif status and status.refused > refused:
                patience.idle = REFUSED
                trouble = f"the robot refuses its commands: {status.refusal}"
            if patience.over:
                self.trial.check()  # one that a signal has stopped is said to be so
                return trouble or f"it has not answered the state at {round(min(now), 6):g} s"
        return ""


def command(controller: str) -> list[str]:
    """The words that start a controller: one of the examples by name, else a command line."""
    if controller in LAWS:
        return [sys.executable, "-m", "flexsim.controller.follow", controller]
    words = shlex.split(controller)
    return [sys.executable, *words] if words[0].endswith(".py") else words


def message(wanted: Trajectory, scene: Scene) -> Any:
    """A trajectory as ROS has it; times count from the robot's zero."""
    from builtin_interfaces.msg import Duration
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    points = []
    for t, position, velocity in zip(wanted.time, wanted.position, wanted.velocity, strict=True):
        sec, nanosec = divmod(round(float(t) * 1e9), 10**9)
        points.append(
            JointTrajectoryPoint(
                positions=position.tolist(),
                velocities=velocity.tolist(),
                time_from_start=Duration(sec=sec, nanosec=nanosec),
            )
        )
    return JointTrajectory(joint_names=list(scene.joint_names), points=points)


def stamp(state: Any) -> float:
    """Simulated time of a message, s."""
    return float(state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec)


def recorded(states: list[Any], shapes: list[Any], until: float, trouble: str, rate: float) -> Recording:
    """States and shapes of the same times, each once."""
    by_time = {stamp(m): m for m in states}
    shape = {stamp(m): m for m in shapes}
    times = sorted(t for t in by_time if t in shape and t <= until + 1e-9)
    rows = [by_time[t] for t in times]
    tips = [(shape[t].position[-3:], shape[t].rigid_position[-3:]) for t in times]
    return Recording(
        np.array(times),
        np.array([m.position for m in rows]),
        np.array([m.velocity for m in rows]),
        np.array([m.effort for m in rows]),
        np.array([tip for tip, _ in tips]).reshape(-1, 3),
        np.array([rigid for _, rigid in tips]).reshape(-1, 3),
        trouble,
        missing(times, rate),
    )


def missing(times: list[float], rate: float) -> int:
    """States that are not among those of these times, s, the last of which ends them.

    A solver that stops publishes the state in which it did, whose time may lie between two periods.
    """
    if not times:
        return 0
    periods = {round(rate * t) for t in times if abs(rate * t - round(rate * t)) < 1e-3}
    return int(rate * times[-1] + 1e-3) + 1 - len(periods)


@contextmanager
def rig(folder: Path, scene: Path, overrides: Mapping[str, Any], rate: float, stopped: Stop) -> Iterator[Rig]:
    """A rig in a ROS domain of its own, all of whose processes have ended afterwards."""
    environment = own_domain()
    os.environ["ROS_DOMAIN_ID"] = environment["ROS_DOMAIN_ID"]
    with (
        processes(folder, environment, stopped) as trial,
        tool_node("bench") as node,
        tool_node("bench_ears") as ears,
    ):
        yield Rig(node, ears, trial, scene, overrides, rate)
