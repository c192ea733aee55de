"""Faults on purpose: what comes between a command and its torque, and between a joint and its sensor.

Everything counts in steps since the robot's first state, and each fault draws from a random sequence of its
own, so that a run is the same whenever its commands are.  What falls within a step happens at the next one's
start, or, where faults are `exact`, at its instant: whoever steps divides the step there (next_change).
"""

from __future__ import annotations

import heapq
import itertools
import math

import numpy as np

from ..scene.load import Scene
from ..scene.schema import Fault

COMMANDS = ("delay", "jitter", "drop", "repeat")
SENSORS = ("quantize", "bias", "noise", "freeze")
LONGEST_LINE = 100_000  # commands on their way
SLACK = 1e-6  # of a step


class Faults:
    """The faults of one robot in motion.

    Parameters
    ----------
    scene : Scene
    step : float, s
    limit : (m,) effort limits, N m or N
    exact : whether faults begin, end and deliver at their instants rather than with whole steps
    """

    def __init__(self, scene: Scene, step: float, limit: np.ndarray, exact: bool = False) -> None:
        self.scene, self.step_size, self.limit, self.exact = scene, step, limit, exact
        names = scene.joint_names
        self._active = [
            (f, moment(f.start, step, exact), math.inf if f.end is None else moment(f.end, step, exact))
            for f in scene.faults
        ]
        self._mask = [
            np.array([f.joints is None or name in f.joints for name in names]) for f in scene.faults
        ]
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        m = len(self.limit)
        self._step: float = 0  # a whole number at the start and end of every step
        self._random = [np.random.default_rng([self.scene.seed, k]) for k in range(len(self.scene.faults))]
        self._number = itertools.count()
        # commands on their way: step due, whether a copy, number, torque
        self._line: list[tuple[float, bool, int, np.ndarray]] = []
        self._last_due: float = 0
        self._wanted = np.zeros(m)  # the torque that has arrived
        self._lagged = np.zeros(m)  # what the motors gave at the start of this step
        self._after = np.zeros(m)  # and at its end
        self._frozen: dict[tuple[int, str], np.ndarray] = {}
        self._measured: dict[str, tuple[float, np.ndarray]] = {}

    def begin(self, step: int, torque: np.ndarray) -> None:
        """Begin anew in mid-run, at this step, with this torque (m,) in force."""
        self.reset()
        self._step = self._last_due = step
        for held in (self._wanted, self._lagged, self._after):
            held[:] = torque

    def _now(self, *kinds: str) -> list[tuple[int, Fault]]:
        """The faults of these kinds that are active in this step, by their place in the scene's list."""
        n = self._step
        return [
            (k, f)
            for k, (f, start, end) in enumerate(self._active)
            if start - SLACK <= n < end - SLACK and f.kind in kinds
        ]

    def arrive(self, torque: np.ndarray) -> None:
        """Take a new command (m,), sent now."""
        due, copies = float(self._step), []
        for k, fault in self._now(*COMMANDS):
            assert fault.kind in COMMANDS
            random = self._random[k]
            if fault.kind == "delay":
                due += (fault.time or 0.0) / self.step_size
            elif fault.kind == "jitter":
                due += random.random() * (fault.time or 0.0) / self.step_size
            elif fault.kind == "drop" and random.random() < (fault.probability or 0.0):
                return
            elif fault.kind == "repeat" and random.random() < (fault.probability or 0.0):
                copies.append((fault.time or 0.0) / self.step_size)
        if len(self._line) >= LONGEST_LINE:
            return
        # The wire keeps the order of what is sent; a copy comes again later.
        self._last_due = max(self._last_due, self._due(due))
        for late in (0.0, *copies):
            arrival = self._due(self._last_due + late)
            copied = late > 0.0  # and behind what arrives with it, or nobody would notice
            heapq.heappush(self._line, (arrival, copied, next(self._number), torque.copy()))

    def _due(self, steps: float) -> float:
        """When what is due after so many steps comes."""
        return steps if self.exact else math.ceil(steps - SLACK)

    def next_change(self) -> float:
        """Steps since the first state until something begins, ends or arrives; else infinite."""
        now = self._step + SLACK
        times = [t for _, start, end in self._active for t in (start, end) if t > now]
        times += [due for due, *_ in self._line if due > now]
        return min(times, default=math.inf)

    @property
    def changed(self) -> bool:
        """Whether something begins, ends or arrives right now."""
        now = self._step
        at = any(abs(t - now) <= SLACK for _, start, end in self._active for t in (start, end))
        return at or any(due <= now + SLACK for due, *_ in self._line[:1])

    def drive(self, torque: np.ndarray, part: float = 1.0) -> None:
        """Write what the motors give at start, middle and end of the coming step into torque (3, m).

        part : of a whole step that the coming one is
        """
        while self._line and self._line[0][0] - SLACK <= self._step:
            self._wanted = heapq.heappop(self._line)[-1]
        torque[:] = np.clip(self._wanted, -self.limit, self.limit)
        h = self.step_size * part
        for k, fault in self._now("lag"):
            mask, rate = self._mask[k], 1.0 / (fault.time_constant or 1.0)
            for row, t in enumerate((0.0, 0.5 * h, h)):
                # first order, exact for a command that is held
                decay = np.exp(-t * rate)
                torque[row, mask] += (self._lagged[mask] - torque[row, mask]) * decay
        self._after[:] = torque[2]
        for k, fault in self._now("saturate"):
            mask, limit = self._mask[k], fault.limit or 0.0
            torque[:, mask] = np.clip(torque[:, mask], -limit, limit)
        for k, fault in self._now("disturbance"):
            torque[:, self._mask[k]] += fault.value or 0.0

    def advance(self, part: float = 1.0) -> None:
        """The step, or a part of it, has been taken."""
        now = self._step + part
        self._step = round(now) if abs(now - round(now)) < SLACK else now
        self._lagged[:] = self._after

    @property
    def step(self) -> float:
        """Steps since the first state; whole where no step is under way."""
        return self._step

    def measure(self, signal: str, values: np.ndarray) -> np.ndarray:
        """What the sensors of a signal say of the true values (m,); the same however often one asks."""
        step, shown = self._measured.get(signal, (-1, values))
        if step == self._step:
            return shown
        shown = values.copy()
        for k, fault in self._now(*SENSORS):
            if fault.signal != signal:
                continue
            mask = self._mask[k]
            if fault.kind == "bias":
                shown[mask] += fault.value or 0.0
            elif fault.kind == "noise":
                # by step, so that it does not matter how often somebody has looked
                random = np.random.default_rng([self.scene.seed, k, int(self._step)])
                drawn = random.standard_normal(len(shown))
                shown[mask] += (fault.deviation or 0.0) * drawn[mask]
            elif fault.kind == "quantize":
                resolution = fault.resolution or 1.0
                shown[mask] = np.round(shown[mask] / resolution) * resolution
            else:
                held = self._frozen.setdefault((k, signal), shown.copy())
                shown[mask] = held[mask]
        self._measured[signal] = (self._step, shown)
        return shown


def first_step(time: float, step: float) -> int:
    """Number of the first step that begins at a time or after it, s."""
    return math.ceil(time / step - 1e-6)


def moment(time: float, step: float, exact: bool) -> float:
    """A time, s, in steps: the first step that begins at it or after it, or where `exact` itself."""
    return time / step if exact else first_step(time, step)


def payload_scenes(scene: Scene, step: float, exact: bool = False) -> list[tuple[float, Scene]]:
    """The steps from which on the links carry something else, and the scene with those payloads.

    The first is the scene itself or what it is from the start; times rise.
    """
    changes = [f for f in scene.faults if f.kind == "payload"]
    times = {0.0, *(f.start for f in changes), *(f.end for f in changes if f.end is not None)}
    found = []
    for time in sorted(times):
        bodies = {f.link: f.body() for f in changes if f.start <= time and (f.end is None or time < f.end)}
        links = tuple(
            link.model_copy(update={"payload": bodies[link.name]}) if link.name in bodies else link
            for link in scene.links
        )
        found.append((moment(time, step, exact), scene.model_copy(update={"links": links})))
    return found
