"""The node's parameters: their defaults, what they mean, and what is refused."""

from __future__ import annotations

import array
import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import reduce
from typing import Any

from .realtime import MODES

OVERRIDE = "override."
# What may be set while the node runs.
CHANGEABLE = (
    "command_timeout",
    "elastic_rate",
    "shape_rate",
    "clock_rate",
    "publish_clock",
    "faults",
)
# Ticks shorter than this would spend the processor on waking up: there, several steps share one.
SHORTEST_TICK = 0.5e-3
SLOWEST = 1e-6  # Hz
SLOWEST_CONTROL, FASTEST_CONTROL = 0.1, 1e5  # Hz; a control period is taken whole
WHOLE = 1e-6  # how far a period may be from a whole number of steps


class SettingError(ValueError):
    """A parameter that can't be: its name, what is wrong, and what would be right."""


def _setting(default: Any, meaning: str) -> Any:
    return field(default=default, metadata={"meaning": meaning})


@dataclass(frozen=True)
class Settings:
    """The parameters of flexsim_node."""

    scene: str = _setting("", "path of the scene's YAML file")
    mode: str = _setting("realtime", "realtime, lockstep or fast")
    rate: float = _setting(
        1000.0, "joint_states a second of simulated time, Hz; in lockstep the control rate"
    )
    elastic_rate: float = _setting(250.0, "elastic_state a second of simulated time, Hz")
    shape_rate: float = _setting(50.0, "deformed_shape a second of simulated time, Hz")
    clock_rate: float = _setting(100.0, "clock ticks a second of simulated time, Hz")
    publish_clock: bool = _setting(True, "whether to publish /clock")
    command_timeout: float = _setting(
        0.0, "s without a command after which the torque becomes zero; 0.0: never"
    )
    wait_for_command: bool = _setting(False, "whether time stands still until the first command")
    faults: str = _setting("", "faults on purpose, a YAML list as in a scene; empty: those of the scene")
    override: Mapping[str, Any] = field(default_factory=dict)


def meanings() -> dict[str, tuple[Any, str]]:
    """Default and meaning of every parameter by name, without the overrides."""
    return {f.name: (f.default, f.metadata["meaning"]) for f in fields(Settings) if f.name != "override"}


def settings(given: Mapping[str, Any]) -> Settings:
    """Check parameters, by name.

    Raises
    ------
    SettingError
    """
    plain = {name: value for name, value in given.items() if not name.startswith(OVERRIDE)}
    override = {
        name.removeprefix(OVERRIDE): list(value) if isinstance(value, array.array) else value
        for name, value in given.items()
        if name.startswith(OVERRIDE)
    }
    found = Settings(**changed(plain), override=override)
    if not found.scene:
        raise SettingError("no scene is given; give one: --ros-args -p scene:=PATH.yaml")
    if found.mode not in MODES:
        raise SettingError(f"mode is {found.mode!r}; give {', '.join(MODES)}")
    return found


def changed(given: Mapping[str, Any]) -> dict[str, Any]:
    """Check each of some parameters by itself.

    Raises
    ------
    SettingError
    """
    known = meanings()
    values: dict[str, Any] = {}
    for name, value in given.items():
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}, {OVERRIDE}<key>"
            raise SettingError(f"unknown parameter {name}; {hint}")
        default = known[name][0]
        if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is not type(default):
            kind = {str: "text", float: "a number", bool: "true or false"}[type(default)]
            raise SettingError(f"{name} is {value!r}; give {kind}: {known[name][1]}")
        values[name] = value
    timeout = values.get("command_timeout", 0.0)
    if not (math.isfinite(timeout) and timeout >= 0.0):
        raise SettingError(f"command_timeout is {timeout}; give seconds, 0.0 for never")
    return values


@dataclass(frozen=True)
class Schedule:
    """How long a step and a tick are, and every how many ticks each topic is due."""

    step: float  # s
    steps: int  # of a tick
    state: int
    elastic: int
    shape: int
    clock: int


def schedule(given: Settings, step: float, tick: int | None = None) -> Schedule:
    """Fit the rates of a node to its scene's step.

    The step is the scene's, shortened where it must be so that a whole number of them makes 1/rate,
    as `simulate` does with its sample_period.  The tick's steps are found where they are not given.

    Raises
    ------
    SettingError
        where a rate can't be kept with whole steps
    """
    if not SLOWEST_CONTROL <= given.rate <= FASTEST_CONTROL:
        raise SettingError(f"rate is {given.rate}; give {SLOWEST_CONTROL:g} to {FASTEST_CONTROL:g} Hz")
    period = 1.0 / given.rate
    whole = max(1, math.ceil(period / step - 1e-9))
    step = period / whole
    periods = {"rate": whole}
    for name in ("elastic_rate", "shape_rate", "clock_rate"):
        rate = getattr(given, name)
        if not (math.isfinite(rate) and SLOWEST <= rate <= 1.0 / step * (1.0 + WHOLE)):
            raise SettingError(f"{name} is {rate}; give Hz, at most {1.0 / step:g}, a step each")
        steps = 1.0 / (rate * step)
        periods[name] = round(steps)
        if abs(steps - periods[name]) > WHOLE * steps:
            near = 1.0 / (periods[name] * step)
            raise SettingError(
                f"{name} is {rate:g} Hz, {steps:.4g} steps of {step:g} s; "
                f"give a whole number of steps: {near:g} Hz"
            )
    if tick is None:
        tick = _tick(given.mode, step, periods)
    for name, steps in periods.items():
        if steps % tick:
            near = 1.0 / (max(1, round(steps / tick)) * tick * step)
            raise SettingError(
                f"{name} is {getattr(given, name):g} Hz, {steps / tick:.4g} ticks of {tick * step:g} s;"
                f" give a whole number of ticks: {near:g} Hz"
            )
    ticks = {name: steps // tick for name, steps in periods.items()}
    return Schedule(
        step, tick, ticks["rate"], ticks["elastic_rate"], ticks["shape_rate"], ticks["clock_rate"]
    )


def _tick(mode: str, step: float, periods: Mapping[str, int]) -> int:
    """Steps of a tick, where these are the steps of each topic's period."""
    if mode == "lockstep":
        return periods["rate"]  # one command, one control period
    common = reduce(math.gcd, periods.values())
    small = [k for k in range(1, math.isqrt(common) + 1) if common % k == 0]
    divisors = sorted({*small, *(common // k for k in small)})
    return next((k for k in divisors if k * step >= SHORTEST_TICK * (1.0 - WHOLE)), common)
