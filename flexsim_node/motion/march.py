"""A whole run in compiled code, without Python's lock: steps, a law's torques, and what is kept of them.

The step and the law are called by address, so that a robot moves as it does when Python takes its steps, to
the last bit, and these loops are compiled once for all robots.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from ..compiled.by_address import by_address
from ..compiled.kernel import kernel
from ..equations.dynamics.acceleration import OK
from .envelope import ROOM

VECTOR = types.Array(types.float64, 1, "C")
# time, position (m,), velocity (m,), given (g,), memory (l,), and the torque (m,) that it writes
LAW = (types.float64, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR)
take_step = by_address(types.int64, types.voidptr, types.float64, types.float64, types.boolean)
ask_law = by_address(types.none, *LAW)

# entries of Record.account: status of the last step, samples kept, what was wrong with a torque and at which
# joint, the piece at whose end the envelope was left or -1, looks of the watch that are kept
STATUS, KEPT, TROUBLE, JOINT, LEFT, LOOKS, ENTRIES = range(7)
NOTHING, NOT_FINITE, PASSIVE = range(3)


class Marcher(NamedTuple):
    """A robot as the march sees it: m joints, n unknowns."""

    step: Any  # address of the method's step
    image: Any  # and of the robot's image
    step_size: float  # s
    option: float  # of the method
    x: np.ndarray  # (n,)
    v: np.ndarray  # (n,)
    torque: np.ndarray  # (3, m)
    arrival: np.ndarray  # (n,) accelerations at the step's end
    seen: np.ndarray  # (2, 3) what the watch of every step saw


class Tape(NamedTuple):
    """The steps of a run, P pieces of them."""

    begin: np.ndarray  # (P,) s, of the step that it is of
    read: np.ndarray  # (P, 3) s, where torques are read: its own begin, middle and end
    length: np.ndarray  # (P,) s
    end: np.ndarray  # (P,) s, of the step
    jumped: np.ndarray  # (P,) bool: the method begins anew
    ends: np.ndarray  # (P,) bool: a step ends with it
    closes: np.ndarray  # (P,) bool: a sample is taken at its end
    asks: np.ndarray  # (P,) bool: a law is asked at its begin
    row: np.ndarray  # (P,) int64: of the table of torques
    looks: np.ndarray  # (K,) bool: samples at which the rest of the watch looks
    last: float  # s, when the last sample is taken


class Law(NamedTuple):
    """Where torques come from: a table, or a compiled law."""

    table: np.ndarray  # (T, 3, m) at start, middle and end of a piece
    address: Any  # of the law
    feeds_back: bool  # whether it is a law
    given: np.ndarray  # (g,)
    memory: np.ndarray  # (l,)
    position: np.ndarray  # (m,)
    velocity: np.ndarray  # (m,)
    out: np.ndarray  # (m,)
    limit: np.ndarray  # (m,) efforts
    actuated: np.ndarray  # (m,) bool
    turned: np.ndarray  # (m,) int64: the unknowns that encoders show
    twisted: np.ndarray  # (m,) int64: what comes on top of them, or -1


class Scope(NamedTuple):
    """The envelope of what was decided, m joints; speed is empty where there is none."""

    low: np.ndarray
    high: np.ndarray
    speed: np.ndarray
    torque: np.ndarray
    duration: float
    stops: bool  # whether the run ends outside
    position: np.ndarray  # (m,) where and how it was left
    rate: np.ndarray
    effort: np.ndarray


class Record(NamedTuple):
    """What is kept, K samples."""

    states: np.ndarray  # (K, 2, n)
    clock: np.ndarray  # (K,) s, the robot's own
    torque: np.ndarray  # (K, m), of a law
    arrival: np.ndarray  # (looks, n)
    seen: np.ndarray  # (looks, 2, 3)
    time: np.ndarray  # (1,) s, at the end
    account: np.ndarray  # (ENTRIES,) int64, see above


@kernel
def march(robot, tape, law, scope, record):
    """Begin a run and take its steps; record.account says how it ended."""
    account = record.account
    account[STATUS], account[KEPT], account[TROUBLE], account[LEFT], account[LOOKS] = OK, 0, NOTHING, -1, 0
    record.time[0] = 0.0
    command(robot, tape, law, 0, account)
    if account[TROUBLE] == NOTHING:
        account[STATUS] = take_step(robot.step, robot.image, robot.step_size, robot.option, True)
    keep(robot, tape, law, record)
    if account[TROUBLE] != NOTHING or account[STATUS] != OK:
        return
    for p in range(tape.length.size):
        if p > 0:
            command(robot, tape, law, p, account)
            if tape.closes[p - 1]:
                keep(robot, tape, law, record)
            if account[TROUBLE] != NOTHING:
                return
        length = tape.length[p]
        if tape.jumped[p]:
            account[STATUS] = take_step(robot.step, robot.image, length, robot.option, True)
        if account[STATUS] == OK:
            account[STATUS] = take_step(robot.step, robot.image, length, robot.option, False)
        if account[STATUS] != OK:
            return
        record.time[0] += length
        if tape.ends[p] and scope.speed.size > 0 and account[LEFT] < 0:
            look_around(robot, tape, law, scope, p, account)
            if account[LEFT] >= 0 and scope.stops:
                return
    if tape.length.size > 0:
        if law.feeds_back:
            ask(robot, law, tape.last, account)
        keep(robot, tape, law, record)


@kernel
def command(robot, tape, law, p, account):
    """Set the torques of a piece."""
    if law.feeds_back:
        if p == 0 or tape.asks[p]:
            ask(robot, law, tape.begin[p] if p < tape.begin.size else 0.0, account)
        return
    row = law.table[tape.row[p] if p < tape.row.size else 0]
    for r in range(3):
        for i in range(row.shape[1]):
            robot.torque[r, i] = row[r, i]
            if not abs(row[r, i]) < np.inf:
                account[TROUBLE], account[JOINT] = NOT_FINITE, i


@kernel
def ask(robot, law, t, account):
    """Set the torques that a law answers at time t, within the efforts' limits."""
    show(law, robot.x, law.position)
    show(law, robot.v, law.velocity)
    for i in range(law.out.size):
        law.out[i] = 0.0
    ask_law(law.address, t, law.position, law.velocity, law.given, law.memory, law.out)
    for i in range(law.out.size):
        effort = law.out[i]
        if not abs(effort) < np.inf:
            account[TROUBLE], account[JOINT] = NOT_FINITE, i
        elif effort != 0.0 and not law.actuated[i]:
            account[TROUBLE], account[JOINT] = PASSIVE, i
        effort = min(max(effort, -law.limit[i]), law.limit[i])
        for r in range(3):
            robot.torque[r, i] = effort


@kernel
def show(law, y, out):
    """Write what the motors' encoders show of the unknowns, or of their rates (Model.shown)."""
    for i in range(out.size):
        out[i] = y[law.turned[i]]
        if law.twisted[i] >= 0:
            out[i] += y[law.twisted[i]]


@kernel
def keep(robot, tape, law, record):
    """Keep the state as the next sample."""
    account = record.account
    k = account[KEPT]
    for i in range(robot.x.size):
        record.states[k, 0, i], record.states[k, 1, i] = robot.x[i], robot.v[i]
    record.clock[k] = record.time[0]
    if law.feeds_back:
        for i in range(law.out.size):
            record.torque[k, i] = robot.torque[0, i]
    if tape.looks[k]:
        place = account[LOOKS]
        account[LOOKS] = place + 1
        for i in range(robot.x.size):
            record.arrival[place, i] = robot.arrival[i]
        for r in range(2):
            for i in range(3):
                record.seen[place, r, i] = robot.seen[r, i]
    account[KEPT] = k + 1


@kernel
def look_around(robot, tape, law, scope, p, account):
    """Note it where the state after piece p is outside of the envelope (Envelope.beyond)."""
    t = tape.end[p]
    show(law, robot.x, law.position)
    show(law, robot.v, law.velocity)
    out = t > scope.duration and t > scope.duration * (1.0 + ROOM)
    for i in range(law.position.size):
        out = out or abs(robot.torque[2, i]) > scope.torque[i] or abs(law.velocity[i]) > scope.speed[i]
        out = out or law.position[i] < scope.low[i] or law.position[i] > scope.high[i]
    if out:
        account[LEFT] = p
        for i in range(law.position.size):
            scope.position[i], scope.rate[i] = law.position[i], law.velocity[i]
            scope.effort[i] = robot.torque[2, i]
