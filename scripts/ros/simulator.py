"""Watch on a simulator that we wait for: whether its time goes on, and if not, why.

Everyone who waits for flexsim_node or thermal_node asks here, and nowhere else; the node says it on ~/status
(docs/node.md).
"""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

from ..terminal.child import ending

if TYPE_CHECKING:
    from subprocess import Popen

    from rclpy.node import Node

# The status comes twice a second.  Who has not heard it for so long, s, has to do with a process that hangs,
# was stopped by a signal, or is gone.
SILENT = 10.0
# The most, s, that counts as silence from look to look: a watcher that was held up itself could not hear.
LOOKED = 0.5


class SimulatorWatch:
    """Hears the status of one simulator.

    In an executor it hears by itself; else `poll` does.  Ask `trouble` and `gone` again and again.

    Parameters
    ----------
    node : rclpy.node.Node
        Who waits.
    name : str
        The simulator's node: "flexsim_node", or with its namespace "/cell/flexsim_node".
    child : Popen or None
        Its process, where we have started it.

    Attributes
    ----------
    status : SimulatorStatus or None, the last that was heard
    """

    def __init__(self, node: Node, name: str, child: Popen[bytes] | None = None) -> None:
        from diagnostic_msgs.msg import DiagnosticStatus
        from flexsim_ros.status import LATCHED, SimulatorStatus

        self.name, self.child = name.rpartition("/")[2], child
        self.status: SimulatorStatus | None = None
        self._node, self._kind = node, DiagnosticStatus
        self._subscription = node.create_subscription(DiagnosticStatus, f"{name}/status", self._take, LATCHED)
        self._silence, self._looked = 0.0, time.monotonic()
        self._told = ("", "", 0)

    def poll(self) -> None:
        """Take what has come, where no executor does."""
        handle = self._subscription.handle
        with handle:
            while (taken := handle.take_message(self._kind, False)) is not None:
                self._take(taken[0])

    def _take(self, message: Any) -> None:
        from flexsim_ros.status import from_message

        self.status = from_message(message)
        self._silence = 0.0

    def close(self) -> None:
        """End hearing."""
        self._node.destroy_subscription(self._subscription)

    @property
    def trouble(self) -> str:
        """Why its time can't go on until a reset, or nothing."""
        if self.status is None or not self.status.reason:
            return ""
        return f"{self.name} stands still at {self.status.time:.6g} s: {self.status.reason}"

    @property
    def gone(self) -> str:
        """Why nothing can be expected of its process any more, or nothing."""
        now = time.monotonic()
        self._silence += min(now - self._looked, LOOKED)
        self._looked = now
        if self.child is not None and self.child.poll() is not None:
            return f"{self.name} {ending(self.child.returncode)}"
        if self.status is None:
            return ""
        if self.status.phase == "quit":
            return f"{self.name} has ended"
        if self.silent and (self.child or not self._node.count_publishers(self._subscription.topic_name)):
            return f"nothing was heard of {self.name} for {SILENT:g} s: it hangs, or is gone"
        return ""

    @property
    def silent(self) -> bool:
        """Whether it has said nothing for too long; `gone` keeps the time."""
        return self.status is not None and self._silence > SILENT

    def other_scene(self, name: str) -> str:
        """Say so, in a sentence, where what it simulates has another name than the scene we were given."""
        if self.status is None or self.status.scene in ("", name):
            return ""
        return f"{self.name} simulates {self.status.scene}, not {name}"

    def look(self) -> str:
        """Poll, print what has changed on standard error, and return why it is gone, or nothing."""
        self.poll()
        if news := self.news():
            print(news, file=sys.stderr, flush=True)
        return self.gone

    def news(self) -> str:
        """What has changed since the last call, in a sentence; nothing where all goes on as it did."""
        status = self.status
        if status is None:
            return ""
        before, self._told = self._told, (status.phase, status.reason, status.resets)
        if status.reason and (status.reason, status.resets) != before[1:]:
            return self.trouble
        if before[0] and status.resets > before[2]:
            return f"{self.name} was reset to its first state"
        if status.phase == "paused" and before[0] not in ("", "paused"):
            return f"{self.name} was paused at {status.time:.6g} s"
        return ""
