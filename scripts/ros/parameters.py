"""The parameters of a running simulator, asked for beside other work."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.node import Node

# s after which a question is asked again: a node that does not spin yet may never see the first one.
PATIENCE = 1.0


class ParameterQuestion:
    """Asks a node for all of its parameters; `step` until there is an answer.

    Answers are polled for, as a recorder's messages are, so `node` must not be in an executor.

    Parameters
    ----------
    node : rclpy.node.Node
        Who asks.
    name : str
        Who is asked, with its leading slash.
    """

    def __init__(self, node: Node, name: str) -> None:
        from rcl_interfaces.srv import GetParameters, ListParameters

        self.name = name
        self._node = node
        self._list: Client = node.create_client(ListParameters, f"{name}/list_parameters")
        self._get: Client = node.create_client(GetParameters, f"{name}/get_parameters")
        self._names: list[str] | None = None
        self._asked = 0.0

    def step(self) -> dict[str, Any] | None:
        """Go on asking; the parameters by name as soon as they are known."""
        from rclpy.parameter import parameter_value_to_python

        client = self._list if self._names is None else self._get
        answer = taken(client)
        if answer is None:
            self._ask(client)
            return None
        self._asked = 0.0
        if self._names is None:
            self._names = list(answer.result.names)
            self._ask(self._get)
            return None
        values = (parameter_value_to_python(v) for v in answer.values)
        return {
            name: value if isinstance(value, (str, bytes)) or not hasattr(value, "__iter__") else list(value)
            for name, value in zip(self._names, values, strict=False)
        }

    def close(self) -> None:
        """End asking."""
        self._node.destroy_client(self._list)
        self._node.destroy_client(self._get)

    def _ask(self, client: Client) -> None:
        now = time.monotonic()
        if now - self._asked < PATIENCE or not client.service_is_ready():
            return
        self._asked = now
        kind: Any = client.srv_type
        request = kind.Request() if self._names is None else kind.Request(names=self._names)
        with client.handle:
            client.handle.send_request(request)


def taken(client: Client) -> Any:
    """Return an answer that came in, or None."""
    kind: Any = client.srv_type
    with client.handle:
        return client.handle.take_response(kind.Response)[1]
