"""A hard case, how it is judged, and the scenes that robots' cases are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexsim_node import Run, load_scene

Scene = dict[str, Any]
STEEL = {"width": 0.01, "depth": 0.03, "density": 7800.0, "youngs_modulus": 2e11, "elements": 2}


@dataclass(frozen=True)
class Outcome:
    """What a case gave: whether it held, how the run ended, and the figures that decide it."""

    held: bool
    ended: str
    figures: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Case:
    """One hard case.

    Attributes
    ----------
    name : str
    why : why it is hard, a sentence
    holds : what must hold, a sentence
    play : runs it and judges
    """

    name: str
    why: str
    holds: str
    play: Callable[[], Outcome]


def bar(name: str, length: float, **keys: Any) -> Scene:
    """A steel link in the plane; `beam` changes its beam."""
    beam = {**STEEL, **keys.pop("beam", {})}
    return {"name": name, "dh": {"a": length}, "beam": beam, **keys}


def planar(*links: Scene, **keys: Any) -> Scene:
    """A robot in a vertical plane, undamped."""
    return {"model": "robot", "name": "hard", "gravity": [0.0, -9.81, 0.0], "links": list(links), **keys}


def arm(**keys: Any) -> Scene:
    """The thesis' anthropomorphic arm in steel."""
    quarter = 0.5 * np.pi
    return {
        "model": "robot",
        "name": "hard",
        "links": [
            {"name": "post", "dh": {"d": 0.5, "alpha": quarter}, "beam": STEEL},
            {"name": "upper_arm", "dh": {"a": 0.5}, "beam": STEEL},
            {"name": "forearm", "dh": {"a": 0.5}, "beam": STEEL},
        ],
        **keys,
    }


def finite(run: Run) -> bool:
    """Whether everything that a run gives is a number."""
    return all(
        np.all(np.isfinite(getattr(run, name)))
        for name in ("joint_position", "joint_velocity", "link_end", "node_displacement", "energy")
    )


def drift(run: Run) -> float:
    """Change of the energy relative to the kinetic energy's scale: what was exchanged, J over J."""
    height = run.link_end[:, :, :] - run.link_end[0]
    exchanged = max(float(np.ptp(run.energy)), 1e-3 * float(np.max(np.abs(height)) + 1e-9))
    return float(np.max(np.abs(run.energy - run.energy[0]))) / exchanged


def weight_moved(scene: Scene, run: Run) -> float:
    """Energy that gravity exchanged with the robot, J: weights times the height their links' ends moved."""
    loaded = load_scene(scene)
    gravity = np.array(loaded.gravity)
    moved = 0.0
    for n, link in enumerate(loaded.links):
        mass = link.payload.mass if link.payload else 0.0
        if link.beam is not None and link.beam.width and link.beam.depth:
            mass += link.beam.density * link.beam.width * link.beam.depth * link.length
        moved += mass * float(np.max(np.abs((run.link_end[:, n] - run.link_end[0, n]) @ gravity)))
    return moved


def balanced(scene: Scene, run: Run, allowed: float) -> Outcome:
    """An undriven, undamped run: finite to its end, its energy kept to `allowed` of what gravity moved."""
    change = float(np.max(np.abs(run.energy - run.energy[0]))) / max(weight_moved(scene, run), 1e-12)
    return Outcome(
        run.status == "ok" and finite(run) and change <= allowed,
        run.status,
        {"energy drift": change, "elastic rotation, rad": run.validity["elastic_rotation"]},
    )


def never_rising(scene: Scene, run: Run, allowed: float) -> Outcome:
    """An undriven run with losses: its energy never rises by more than `allowed` of what it lost."""
    lost = float(run.energy[0] - run.energy[-1])
    risen = float(np.max(run.energy - np.minimum.accumulate(run.energy)))
    share = risen / max(lost, 1e-12)
    return Outcome(
        run.status == "ok" and finite(run) and lost > 0.0 and share <= allowed,
        run.status,
        {"energy lost, J": lost, "energy risen, share": share},
    )


def bounded(run: Run, reach: float) -> Outcome:
    """A driven run: finite to its end, its end never further than the robot reaches."""
    far = float(np.max(np.linalg.norm(run.link_end[:, -1], axis=1)))
    return Outcome(
        run.status == "ok" and finite(run) and far <= 1.05 * reach,
        run.status,
        {"farthest, m": far, "elastic rotation, rad": run.validity["elastic_rotation"]},
    )


def stopped(run: Run, *reasons: str) -> Outcome:
    """A run that must not go on: it stops with one of the reasons, finite to the last sample."""
    right = any(reason in run.status for reason in reasons)
    return Outcome(right and finite(run), run.status, {"stopped at, s": float(run.time[-1])})


def close(run: Run, found: float, right: float, allowed: float, name: str) -> Outcome:
    """A run with a known answer, met to `allowed` of it."""
    off = abs(found - right) / abs(right)
    return Outcome(
        run.status == "ok" and finite(run) and off <= allowed,
        run.status,
        {name: found, "right": right, "off": off},
    )
