"""The scene that a simulator runs, as it publishes it: whole, with its hash, as JSON.  Needs no ROS.

    {"format": 1, "simulator": "flexsim_node", "hash": "sha256:...", "scene": {...}, "parameters": {...},
     "overrides": {...}, "effects": [...], "file": "/home/me/arm.yaml", "since": 0.0, "ticks": 0,
     "versions": {"flexsim": "0.1.0", ...}}

`scene` has every key (of links by frames, those that are used): overrides taken in, formulation and effects
decided, nothing of it in another file.
The hash is of `scene` alone: equal hashes mean equal scenes, whatever file they came from.
"""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any

FORMAT = 1
TOPIC = "scene"
TYPE = "std_msgs/msg/String"
PACKAGES = ("flexsim", "numpy", "numba", "llvmlite", "scipy")


class SceneSpoilt(ValueError):
    """A published scene that can't be trusted: of another format, or not fitting its hash."""


@dataclass(frozen=True)
class PublishedScene:
    """A scene as its simulator told it.

    Attributes
    ----------
    simulator : "flexsim_node" or "thermal_node"
    scene : every key of the scene, as `load_scene` takes it
    hash : of `scene`
    parameters : of the node, by name, without the overrides
    overrides : what the node was told to change of the file; `scene` has them
    effects : a line for the formulation, and each effect, that the file left open, and how it was decided
    file : path of the scene's file, as the node was given it
    since, ticks : simulated time, s, and ticks since the node's start, from which on it holds
    versions : by package
    """

    simulator: str
    scene: Mapping[str, Any]
    hash: str
    parameters: Mapping[str, Any]
    overrides: Mapping[str, Any] = field(default_factory=dict)
    effects: Sequence[str] = ()
    file: str = ""
    since: float = 0.0
    ticks: int = 0
    versions: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The scene's own name."""
        return str(self.scene.get("name", ""))


def scene_hash(scene: Mapping[str, Any]) -> str:
    """SHA-256 of a scene as JSON: keys sorted, no spaces, ASCII, numbers in their shortest digits."""
    text = json.dumps(scene, sort_keys=True, separators=(",", ":"))
    return f"sha256:{hashlib.sha256(text.encode()).hexdigest()}"


def versions() -> dict[str, str]:
    """What a run's numbers may depend on, by package."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:  # of a native ROS, where only colcon knows us
            found[package] = "unknown"
    return found


def scene_text(
    simulator: str,
    scene: Mapping[str, Any],
    parameters: Mapping[str, Any],
    *,
    overrides: Mapping[str, Any],
    effects: Sequence[str] = (),
    file: str = "",
    since: float = 0.0,
    ticks: int = 0,
) -> str:
    """Text of a scene for a simulator's `~/scene`; see PublishedScene."""
    plain = json.loads(json.dumps(scene))  # as who reads it will have it: lists, no tuples
    return json.dumps(
        {
            "format": FORMAT,
            "simulator": simulator,
            "hash": scene_hash(plain),
            "scene": plain,
            "parameters": dict(parameters),
            "overrides": dict(overrides),
            "effects": list(effects),
            "file": file,
            "since": since,
            "ticks": ticks,
            "versions": versions(),
        }
    )


def read_published_scene(text: str) -> PublishedScene | None:
    """Read what a simulator published; None for a text that is nothing of the kind.

    Raises
    ------
    SceneSpoilt
    """
    try:
        told = json.loads(text)
    except ValueError:
        return None
    if not (
        isinstance(told, dict) and isinstance(told.get("scene"), dict) and {"hash", "simulator"} <= set(told)
    ):
        return None
    if told.get("format") != FORMAT:
        raise SceneSpoilt(f"has format {told.get('format')!r}; this version reads {FORMAT}")
    if scene_hash(told["scene"]) != told["hash"]:
        raise SceneSpoilt("does not fit its hash: it was damaged or changed")
    known = {name: told[name] for name in PublishedScene.__dataclass_fields__ if name in told}
    try:
        return PublishedScene(**known)
    except TypeError as problem:
        raise SceneSpoilt(f"lacks a part: {problem}") from None
