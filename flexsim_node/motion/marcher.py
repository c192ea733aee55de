"""Runs of one robot after the other in compiled code (march.py), each as motion/run.py makes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..compiled.by_address import address, image
from ..equations.dynamics.acceleration import NOT_VALID, OK
from ..integrators import METHODS
from ..scene.schema import Scene
from .envelope import Envelope
from .jumps import Jumps
from .march import (
    ENTRIES,
    JOINT,
    KEPT,
    LEFT,
    LOOKS,
    NOT_FINITE,
    PASSIVE,
    STATUS,
    TROUBLE,
    Law,
    Marcher,
    Record,
    Scope,
    Tape,
    march,
)
from .run import TORQUE_NOT_FINITE, Torque, torque_function
from .simulation import Simulation
from .validity import LOOK_PERIOD


@dataclass(frozen=True)
class Marched:
    """How one run ended.

    Attributes
    ----------
    kept : samples that were taken
    status : "ok", or why it ended before its time
    left : what left the envelope of what was decided, in words, or ""
    validity : (figures,) the largest of each figure of the validity watch
    warnings : what passed a limit without ending the run
    """

    kept: int
    status: str
    left: str
    validity: np.ndarray
    warnings: tuple[str, ...]


class Tapes:
    """The pieces of runs with the same samples.

    times : (K,) s of the samples, `period` s and `substeps` steps of `step` s apart
    """

    def __init__(self, times: np.ndarray, period: float, substeps: int, step: float) -> None:
        self.times, self.period, self.substeps, self.step = times, period, substeps, step
        self.looks, next_look = np.zeros(len(times), dtype=bool), 0.0
        for k, t in enumerate(times):
            if t >= next_look or k == len(times) - 1:
                self.looks[k], next_look = True, t + LOOK_PERIOD
        self.last: tuple[tuple[Any, ...], Tape] | None = None

    def of(self, cuts: Jumps, control: int = 1) -> Tape:
        """A run's pieces where torques jump at some times, and a law answers every `control` steps."""
        key = (tuple(cuts.times), control)
        if self.last is None or self.last[0] != key:
            self.last = key, self._cut(cuts, control)
        return self.last[1]

    def _cut(self, cuts: Jumps, control: int) -> Tape:
        rows: list[tuple[float, ...]] = []
        step, substeps = self.step, self.substeps
        for k in range(len(self.times) - 1):
            for n in range(substeps):
                t = self.times[k] + n * step
                pieces = cuts.pieces(t, step)
                for i, piece in enumerate(pieces):
                    final, asked = i == len(pieces) - 1, i == 0 and (k * substeps + n) % control == 0
                    at = piece.begin, piece.begin + 0.5 * piece.length, piece.end
                    flags = piece.jumped, final, final and n == substeps - 1, asked
                    rows.append((t, *at, piece.length, t + step, *flags))
        columns = np.ascontiguousarray(np.array(rows, dtype=float).reshape(-1, 10).T)
        begin, *read, length, end = columns[:6]
        jumped, ends, closes, asks = columns[6:] > 0.0
        row = np.zeros(len(begin), dtype=np.int64)
        middle = np.ascontiguousarray(np.transpose(read))
        last = float(self.times[-1])
        return Tape(begin, middle, length, end, jumped, ends, closes, asks, row, self.looks, last)


class Marching:
    """A robot that makes many runs, one after the other, in buffers of its own."""

    def __init__(self, scene: Scene, tapes: Tapes, envelope: Envelope | None) -> None:
        self.robot = robot = Simulation(scene, tapes.step)
        self.tapes, self.envelope = tapes, envelope
        # the last torques, and where they came from
        self.kept: tuple[Any, Any, tuple[Tape, Law]] | None = None
        m, n = robot.model.joints, robot.model.unknowns
        robot.warm()
        self.marcher = Marcher(
            address(METHODS[robot.method].step, robot.arrays, robot.step_size, robot.option, False),
            image(robot.arrays), robot.step_size, robot.option, robot.x, robot.v, robot.torque,
            robot.work.arrival, robot.work.validity,
        )  # fmt: skip
        model = robot.model
        self.twisted = np.where((model.turn >= 0) & (model.motor < 0), model.turn, -1)
        none, here = np.zeros(0), np.zeros((3, m))
        self.scope = Scope(none, none, none, none, 0.0, False, here[0], here[1], here[2])
        if envelope is not None:
            self.scope = self.scope._replace(
                low=envelope.low, high=envelope.high, speed=envelope.speed, torque=envelope.torque,
                duration=float(envelope.duration), stops=scene.auto.beyond != "warn",
            )  # fmt: skip
        self.record = Record(
            np.zeros((0, 2, n)), np.zeros(0), np.zeros((0, m)), np.zeros((0, n)), np.zeros((0, 2, 3)),
            np.zeros(1), np.zeros(ENTRIES, dtype=np.int64),
        )  # fmt: skip

    def room(self, tape: Tape) -> None:
        """Make room for the samples of a run."""
        samples, looks = len(tape.looks), int(np.sum(tape.looks))
        n, m = self.robot.model.unknowns, self.robot.model.joints
        if len(self.record.clock) != samples or len(self.record.arrival) != looks:
            self.record = self.record._replace(
                states=np.zeros((samples, 2, n)), clock=np.zeros(samples), torque=np.zeros((samples, m)),
                arrival=np.zeros((looks, n)), seen=np.zeros((looks, 2, 3)),
            )  # fmt: skip

    def goes_on(self, scene: Scene, envelope: Envelope | None) -> bool:
        """Whether a scene is of this robot, which then goes to its start; else nothing has changed."""
        own = self.robot.scene
        if (
            scene is not own
            and scene.model_copy(update={"initial": own.initial, "torque": own.torque}) != own
        ):
            return False
        if envelope is not self.envelope:
            return False
        self.robot.start_at(scene)
        return True

    def driven(self, tape: Tape, torque: Torque, source: Any) -> tuple[Tape, Law]:
        """Torques as of simulate: none, a function of time, or an array (K, m) held between samples.

        source : what they are of; as long as it is the same they are not asked for anew
        """
        if self.kept is not None and self.kept[0] is tape and self.kept[1] is source:
            return self.kept[2]
        robot, m, period = self.robot, self.robot.model.joints, self.tapes.period
        applied = torque_function(torque, m, period, robot)
        if callable(torque):
            # of a run without a step there is none
            instants = tape.read if len(tape.read) else np.zeros((1, 3))
            table = np.array([[applied(t) for t in three] for three in instants])
            row: np.ndarray = np.arange(len(tape.read))
        else:
            count = 1 if torque is None else len(torque)
            table = np.array([[applied(k * period)] * 3 for k in range(count)])
            row = np.minimum((tape.begin / period + 1e-6).astype(np.int64), count - 1)
        self.applied = applied
        self.kept = tape, source, (tape._replace(row=row), self._law(table))
        return self.kept[2]

    def fed_back(self, law: Any, given: np.ndarray, memory: int) -> Law:
        """Torques that a compiled law, by its address, answers; it gets `given` (g,)."""
        table = np.zeros((1, 3, self.robot.model.joints))
        return self._law(table)._replace(
            address=law, feeds_back=True, given=np.array(given), memory=np.zeros(memory)
        )

    def _law(self, table: np.ndarray) -> Law:
        model, m = self.robot.model, self.robot.model.joints
        none, own = np.zeros(0), np.zeros((3, m))
        return Law(
            table, 0, False, none, none, own[0], own[1], own[2], self.robot.limit,
            model.actuated, model.turned, self.twisted,
        )  # fmt: skip

    def torques(self, law: Law, kept: int) -> np.ndarray:
        """(kept, m) in force from each of the last run's samples on, N m or N."""
        if law.feeds_back:
            return self.record.torque[:kept]
        return np.array([self.applied(t) for t in self.tapes.times[:kept]])

    def run(self, tape: Tape, law: Law) -> Marched:
        """Make a run from the scene's start; its states are in `record`."""
        robot = self.robot
        robot.reset()
        self.room(tape)
        record, account = self.record, self.record.account
        march(self.marcher, tape, law, self.scope, record)
        robot.status, robot.time = int(account[STATUS]), float(record.time[0])
        kept, trouble = int(account[KEPT]), ""
        last_seen = robot.watch.seen.copy()
        places = np.flatnonzero(tape.looks)[: int(account[LOOKS])]
        for j, k in enumerate(places):
            robot.watch.seen[:] = record.seen[j]
            if not robot.watch.look(record.states[k, 0], record.states[k, 1], record.arrival[j]):
                robot.status, robot.time, kept = NOT_VALID, float(record.clock[k]), int(k) + 1
                break
        else:
            robot.watch.seen[:] = last_seen
            if account[TROUBLE] == NOT_FINITE:
                trouble = TORQUE_NOT_FINITE
            elif account[TROUBLE] == PASSIVE:
                name = robot.scene.joint_names[account[JOINT]]
                trouble = f"the law gives a torque on {name}, which is passive; give zero there"
        left = ""
        p = int(account[LEFT])
        if self.envelope is not None and p >= 0 and tape.end[p] <= robot.time + 0.5 * robot.step_size:
            left = self.envelope.beyond(
                float(tape.end[p]), self.scope.position, self.scope.rate, self.scope.effort
            )
        if left and self.scope.stops:
            trouble = left
        if robot.status != OK:
            trouble = robot.reason
        return Marched(
            kept,
            f"stopped at {robot.time:.6g} s: {trouble}" if trouble else "ok",
            left,
            np.array([finding.value for finding in robot.watch.findings()]),
            ((left,) if left and not self.scope.stops else ()) + robot.watch.sentences("warn"),
        )
