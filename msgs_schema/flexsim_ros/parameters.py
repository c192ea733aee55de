"""A node's parameters, declared so that ROS tools see their types, their meanings and what may be set."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

# rclpy's own, which every node takes.
OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")


def given_parameters(node: Node) -> dict[str, Any]:
    """What a node that declares its overrides by itself was started with, by name."""
    declared: dict[str, Any] = node.get_parameters_by_prefix("")
    return {name: p.value for name, p in declared.items() if not name.startswith(OF_ROS)}


def declare_parameters(
    node: Node, values: Mapping[str, Any], meanings: Mapping[str, str], changeable: Collection[str]
) -> None:
    """Declare a node's parameters, in place of what was given.

    Tools guess a type from what was typed: a whole number is taken where a number belongs, and `[]`, which
    they send as a list of truth values, where text does.

    Parameters
    ----------
    values : of all parameters, by name
    meanings : a sentence for each
    changeable : names of those that may be set while the node runs
    """
    for name, value in values.items():
        if node.has_parameter(name):
            node.undeclare_parameter(name)  # declared as it was given, without its meaning
        about = ParameterDescriptor(description=meanings[name], read_only=name not in changeable)
        node.declare_parameter(name, value, about, ignore_override=True)

    def as_declared(given: Parameter) -> Parameter:
        kind = type(values.get(given.name))
        if kind is float and given.type_ == Parameter.Type.INTEGER:
            return Parameter(given.name, value=float(given.value))
        if kind is str and given.type_ == Parameter.Type.BOOL_ARRAY and len(given.value) == 0:
            return Parameter(given.name, value="[]")
        return given

    node.add_pre_set_parameters_callback(lambda parameters: [as_declared(p) for p in parameters])
