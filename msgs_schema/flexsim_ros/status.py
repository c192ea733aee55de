"""What a simulator says on ~/status: whether its time goes on, and if not, why.

The one signal for whoever waits for a simulator.  It is latched, so that who comes late hears it at once;
it is said anew when something changes, and repeated twice a second, so that silence means that the process
has ended or hangs.
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

TOPIC = "status"
PERIOD = 0.5  # s
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# The last word of a process that ends in good order.
QUIT = "quit"


@dataclass(frozen=True)
class SimulatorStatus:
    """How a simulator does.

    Attributes
    ----------
    phase : "waiting" for a command or a measured furnace, "running", "paused", "stopped" by the solver,
        "ended" after a test's duration, or "quit" when the process ends
    reason : why time can't go on until a reset, or nothing
    time : simulated, s
    resets : to the first state, since the process began
    refused : commands, since the process began
    refusal : what was wrong with the last of them
    scene : its name
    """

    phase: str = "waiting"
    reason: str = ""
    time: float = 0.0
    resets: int = 0
    refused: int = 0
    refusal: str = ""
    scene: str = ""


def to_message(status: SimulatorStatus, name: str) -> DiagnosticStatus:
    """Return it as ROS has it; `name` is the simulator's node's."""
    values = {
        "phase": status.phase,
        "reason": status.reason,
        "simulated time, s": f"{status.time:.6f}",
        "resets": str(status.resets),
        "refused commands": str(status.refused),
        "last refusal": status.refusal,
    }
    stopped = status.phase == "stopped"
    return DiagnosticStatus(
        level=DiagnosticStatus.ERROR if stopped else DiagnosticStatus.OK,
        name=name,
        message=f"{status.phase}: {status.reason}" if status.reason else status.phase,
        hardware_id=status.scene,
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )


def from_message(message: DiagnosticStatus) -> SimulatorStatus:
    """Return what a message says; a value that is not there is that of a simulator that has just begun."""
    values = {pair.key: pair.value for pair in message.values}
    return SimulatorStatus(
        phase=values.get("phase", "waiting"),
        reason=values.get("reason", ""),
        time=float(values.get("simulated time, s", "0")),
        resets=int(values.get("resets", "0")),
        refused=int(values.get("refused commands", "0")),
        refusal=values.get("last refusal", ""),
        scene=message.hardware_id,
    )


class StatusPublisher:
    """Says a simulator's status; its node calls `say` again and again, ten times a second or more often."""

    def __init__(self, node: Node) -> None:
        self._name = node.get_fully_qualified_name().lstrip("/")
        self._publisher = node.create_publisher(DiagnosticStatus, f"~/{TOPIC}", LATCHED)
        self._said: tuple[str, str, int] | None = None
        self._next = 0.0

    def say(self, status: SimulatorStatus) -> None:
        """Publish it where it has changed, or where it was not said for PERIOD."""
        now, key = clock.monotonic(), (status.phase, status.reason, status.resets)
        if key == self._said and now < self._next:
            return
        self._said, self._next = key, now + PERIOD
        self._publisher.publish(to_message(status, self._name))
