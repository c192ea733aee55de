"""The parameters of a running simulator, asked for beside other work."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rclpy.node import Node

# s after which a question is asked again.
PATIENCE = 2.0


class ParameterQuestion:
    """Asks a node for all of its parameters; `step` until there is an answer.

    Parameters
    ----------
    name : str
        The node's name, with its leading slash.
    domain : int
    """

    def __init__(self, beside: Node, name: str) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.parameter_client import AsyncParameterClient

        self.name = name
        # A node of its own: the executor would take messages that a recorder polls for.
        self._node = rclpy.create_node(
            f"{beside.get_name()}_asks",
            context=beside.context,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._executor = SingleThreadedExecutor(context=beside.context)
        self._executor.add_node(self._node)
        self._client = AsyncParameterClient(self._node, name)
        self._names: list[str] = []
        self._pending: Any = None
        self._listed = False
        self._asked = 0.0

    def step(self) -> dict[str, Any] | None:
        """Go on asking; the parameters by name as soon as they are known."""
        if self._pending is None:
            if self._client.services_are_ready():
                self._asked = time.monotonic()
                self._pending = self._client.list_parameters()
            return None
        self._executor.spin_once(timeout_sec=0.0)
        if not self._pending.done():
            # A node that was not spinning yet may never see what it was asked before.
            if time.monotonic() - self._asked > PATIENCE:
                self._pending = None
                self._listed = False
            return None
        answer = self._pending.result()
        if not self._listed:
            self._listed = True
            self._names = list(answer.result.names)
            self._pending = self._client.get_parameters(self._names)
            return None
        from rclpy.parameter import parameter_value_to_python

        values = (parameter_value_to_python(v) for v in answer.values)
        return {
            name: value if isinstance(value, (str, bytes)) or not hasattr(value, "__iter__") else list(value)
            for name, value in zip(self._names, values, strict=False)
        }

    def close(self) -> None:
        """End asking."""
        self._executor.shutdown()
        self._node.destroy_node()


def scene_of(parameters: dict[str, Any]) -> tuple[str, bytes] | None:
    """Return the name and the text of the scene that a node simulates; None where there is none."""
    path = Path(str(parameters.get("scene") or ""))
    try:
        return path.name, path.read_bytes()
    except OSError:  # the node runs elsewhere, or its scene is gone
        return None
