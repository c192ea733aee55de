"""A trial in numbers, all of them from its bag."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from numpy.typing import NDArray

from ..bag import Bag
from ..bag.cdr import Decoder

COMMANDS = "/flexsim_node/commands"
STATES = "/joint_states"
ELASTIC = "/flexsim_node/elastic_state"
DIAGNOSTICS = "/diagnostics"


@dataclass(frozen=True)
class Motion:
    """What a trial's robot did, by simulated time; K states, m joints, N nodes.

    Attributes
    ----------
    time : (K,) s; joint_position : (K, m) rad or m
    elastic_time : (E,) s
    position, rigid_position : (E, N, 3) m, base frame
    displacement : (E, N, 6) m and rad, link frames
    """

    time: NDArray[np.float64]
    joint_position: NDArray[np.float64]
    elastic_time: NDArray[np.float64]
    position: NDArray[np.float64]
    rigid_position: NDArray[np.float64]
    displacement: NDArray[np.float64]

    @property
    def tip_deflection(self) -> NDArray[np.float64]:
        """(E,) m: how far the tip is from where the rigid robot has it."""
        return np.asarray(np.linalg.norm(self.position[:, -1] - self.rigid_position[:, -1], axis=1))


def motion(bag: Bag, until: float) -> Motion:
    """Read the robot's motion up to a simulated time, s.

    States that were repeated while time stood still are left out.
    """
    stamps = ["header.stamp.sec", "header.stamp.nanosec"]
    _, states = bag.columns(STATES, [*stamps, "position"])
    _, shapes = bag.columns(ELASTIC, [*stamps, "position", "rigid_position", "displacement"])

    def once(columns: dict[str, NDArray[Any]]) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        time = np.float64(columns[stamps[0]]) + 1e-9 * columns[stamps[1]]
        time, first = np.unique(time, return_index=True)
        wanted = time <= until + 1e-9
        return time[wanted], first[wanted]

    time, i = once(states)
    elastic_time, j = once(shapes)
    return Motion(
        time,
        states["position"][i],
        elastic_time,
        shapes["position"][j].reshape(len(j), -1, 3),
        shapes["rigid_position"][j].reshape(len(j), -1, 3),
        shapes["displacement"][j].reshape(len(j), -1, 6),
    )


def latencies(bag: Bag) -> NDArray[np.float64]:
    """Return, in s, how long after a command was sent the first state that it caused was received.

    A state's effort is the torque that led to it, so it names its command.  Commands that were
    overtaken by another within a step never show; those equal to the one before can't be told,
    and are left out.
    """
    sent, received = [], []
    commands, states = [], []
    for path in bag.files:
        with path.open("rb") as file:
            for _, channel, message in make_reader(file).iter_messages([COMMANDS, STATES]):
                if channel.topic == COMMANDS:
                    sent.append(message.publish_time)
                    commands.append(message.data)
                else:
                    received.append(message.log_time)
                    states.append(message.data)
    if not commands or not states:
        return np.zeros(0)
    torque = _column(bag, COMMANDS, commands, "data")
    effort = _column(bag, STATES, states, "effort")
    shown: dict[bytes, list[int]] = {}
    for time, row in zip(received, effort, strict=True):
        shown.setdefault(row.tobytes(), []).append(time)
    found = []
    before = b""
    for time, row in zip(sent, torque, strict=True):
        this = row.tobytes()
        if this != before:
            after = [t for t in shown.get(this, []) if t >= time]
            if after:
                found.append(min(after) - time)
        before = this
    return np.array(found) * 1e-9


def _column(bag: Bag, topic: str, messages: list[bytes], field: str) -> NDArray[np.float64]:
    found = bag.topic(topic)
    return np.asarray(Decoder(found.type, found.schema).columns(messages, [field])[field])


def last_diagnostics(bag: Bag) -> dict[str, str]:
    """Return the values of the last diagnostic message, by key."""
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.serialization import deserialize_message

    values: dict[str, str] = {}
    for _, data in bag.messages(DIAGNOSTICS):
        for status in deserialize_message(data, DiagnosticArray).status:
            values.update({pair.key: pair.value for pair in status.values})
    if not values:
        raise RuntimeError(f"{bag.path} holds no diagnostics")
    return values


def figures(path: Path, until: float) -> dict[str, Any]:
    """Return a trial's numbers, in SI units; `until` is when its controller ended, simulated s."""
    bag = Bag(path)
    said = last_diagnostics(bag)
    latency = latencies(bag)
    deflection = motion(bag, until).tip_deflection
    p50, p99 = np.quantile(latency, [0.5, 0.99]) if len(latency) else (np.nan, np.nan)
    return {
        "duration": until,
        "real_time_factor": float(said["real-time factor"]),
        "ticks": int(said["ticks"]),
        "overruns": int(said["overruns"]),
        "step_time_p50": 1e-6 * float(said["step time p50, µs"]),
        "step_time_p99": 1e-6 * float(said["step time p99, µs"]),
        "step_time_worst": 1e-6 * float(said["step time worst, µs"]),
        "commands": bag.topic(COMMANDS).count,
        "commands_refused": int(said["refused"]),
        "latency_p50": float(p50),
        "latency_p99": float(p99),
        "latency_samples": len(latency),
        "tip_deflection_rms": float(np.sqrt(np.mean(deflection**2))),
        "tip_deflection_peak": float(deflection.max()),
        "bag_messages": bag.count,
        "bag_bytes": sum(f.stat().st_size for f in path.iterdir()),
    }
