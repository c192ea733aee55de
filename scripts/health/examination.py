"""Reads a bag once and gathers what was not as it should be, each finding with its time."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.diagnostics import TYPE as DIAGNOSTICS
from ..bag.diagnostics import statuses
from ..bag.joints import JointDecoder
from ..bag.messages import Messages
from ..bag.robot import robot_in
from .energy import Gain, gains
from .said import Said
from .timing import HEADER, SECOND, Timing, timings

MOTION = ["position", "effort", *HEADER]


@dataclass(frozen=True)
class Finding:
    """Something that was not as it should be; from when to when, s since the bag's start."""

    begin: float
    end: float | None
    what: str


@dataclass
class Examination:
    """What was found out about a bag.

    Attributes
    ----------
    timings : of each topic
    said : what /diagnostics told
    gained : energy that the joints' work does not account for
    energy_checked : int, pairs of reports whose energy could be held against the joints' work
    """

    timings: dict[str, Timing]
    said: Said
    gained: list[Gain] = field(default_factory=list)
    energy_checked: int = 0

    def findings(self) -> dict[str, list[Finding]]:
        """Return all findings, by kind and time."""
        found: dict[str, list[Finding]] = {}

        def add(kind: str, begin: float, end: float | None, what: str) -> None:
            found.setdefault(kind, []).append(Finding(begin, end, what))

        for t in self.timings.values():
            for jump in t.jumps:
                way = "back" if jump.after < jump.before else "ahead"
                add("clock", jump.at, None, f"{t.topic}: time jumps {way}, from {jump.before:.6f} s to"
                    f" {jump.after:.6f} s")  # fmt: skip
            if t.backwards:
                add(
                    "clock", 0.0, None, f"{t.topic}: {t.backwards} messages were logged before the one before"
                )
        for o in self.said.overruns:
            add("overruns", o.at, None, f"{o.count} deadlines missed since the report before")
        for e in self.said.episodes:
            often = "" if e.times == 1 else f" ({e.times} reports)"
            add(e.word, e.begin, e.end if e.end > e.begin else None, f"{e.name}: {e.message}{often}")
        for g in self.gained:
            add("energy", g.at, None, g.sentence())
        for t in self.timings.values():
            for loss in t.losses:
                those = "message that was sent is" if loss.count == 1 else "messages that were sent are"
                what = f"{t.topic}: {loss.count} {those} not in the bag"
                add("lost", loss.begin, loss.end, what)
            for gap in t.gaps:
                if gap.still:
                    add("stood still", gap.begin, gap.end, f"{t.topic}: simulated time did not go on")
                    continue
                slow = f"; {gap.messages} messages within" if gap.messages else ""
                usual = 1e3 * (t.interval or 0.0)
                add("gap", gap.begin, gap.end, f"{t.topic}: {1e3 * (gap.end - gap.begin):.1f} ms where"
                    f" {usual:.3g} ms are usual{slow}")  # fmt: skip
        for findings in found.values():
            findings.sort(key=lambda f: f.begin)
        return found

    def figures(self) -> dict[str, Any]:
        """Return the findings for --json; times in s since the bag's start."""
        said = self.said
        return {
            "overruns": said.missed,
            "overruns_at": [[o.at, o.count] for o in said.overruns],
            "warnings": [
                {"name": e.name, "level": e.word, "begin": e.begin, "end": e.end, "message": e.message}
                for e in said.episodes
            ],
            "validity": {
                name: {"largest": v.value, "at": v.at, "warn": v.warn, "stop": v.stop}
                for name, v in said.validity.items()
            },
            "energy_gains": [
                {"at": g.at, "time": g.time, "gained": g.gained, "work": g.work} for g in self.gained
            ],
            "energy_checked": self.energy_checked,
        }


class JointWork:
    """Collects what the joints did: position and effort by simulated time."""

    def __init__(self, bag: Bag, topic: str) -> None:
        self._decoder = bag.joints(topic)
        self._parts: list[dict[str, NDArray[Any]]] = []

    def add(self, messages: Messages) -> None:
        """Take up joint states."""
        with suppress(BagError):  # joints that come and go: their work is not known
            some = self._decoder.mine(messages) if isinstance(self._decoder, JointDecoder) else messages
            if len(some):
                self._parts.append(self._decoder.columns(some, MOTION))

    def gains(self, said: Said) -> tuple[list[Gain], int]:
        """Return energy that nothing accounts for, and how many reports could be checked."""
        shapes = {(p["position"].shape[1:], p["effort"].shape[1:]) for p in self._parts}
        if len(shapes) != 1 or len(said.energy) < 2 or len(set(next(iter(shapes)))) != 1:
            return [], 0
        position, effort, sec, nanosec = (np.concatenate([p[n] for p in self._parts]) for n in MOTION)
        stamp = sec.astype(np.int64) * SECOND + nanosec
        # Time that was set back begins another run; of several, the energies can't be told apart.
        if (np.diff(stamp) < 0).any():
            return [], 0
        stamp, first = np.unique(stamp, return_index=True)
        found = gains(said.energy, stamp / SECOND, position[first], effort[first])
        return found, len(said.energy) - 1


def examine(
    bag: Bag,
    progress: Callable[[int], None] = lambda _: None,
    takers: Iterable[tuple[str, Callable[[Messages], Any]]] = (),
) -> Examination:
    """Read all of a bag.

    takers : topics, and what else is to be called with all of their messages
    """
    robot = robot_in(bag)
    said = Said(scene=robot.model)
    also: dict[str, list[Callable[[Messages], Any]]] = {}
    for name, taker in takers:
        also.setdefault(name, []).append(taker)

    def on_diagnostics(messages: Messages) -> None:
        for time, data in zip(bag.seconds(messages.log_time).tolist(), messages.data(), strict=True):
            with suppress(BagError):  # a message that is cut off says nothing
                said.add(time, statuses(data))

    work: JointWork | None = None
    for topic in bag.topics.values():
        if topic.type == DIAGNOSTICS:
            also.setdefault(topic.name, []).append(on_diagnostics)
        elif bag.why_not(topic.name):
            continue
        elif topic.name == robot.joints and topic.name.endswith("joint_states"):
            work = JointWork(bag, topic.name)
            also.setdefault(topic.name, []).append(work.add)
    found = Examination(timings(bag, also, progress), said)
    if work is not None:
        found.gained, found.energy_checked = work.gains(said)
    return found
