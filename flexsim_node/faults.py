"""Faults on purpose: what comes between a command and its torque, and between a joint and its sensor.

Everything counts in whole steps since the robot's first state, and each fault draws from a random sequence of
its own, so that a run is the same whenever its commands are.
"""

from __future__ import annotations

import heapq
import itertools
import math

import numpy as np

from .scene import Scene
from .schema import Fault

COMMANDS = ("delay", "jitter", "drop", "repeat")
SENSORS = ("quantize", "bias", "noise", "freeze")
LONGEST_LINE = 100_000  # commands on their way


class Faults:
    """The faults of one robot in motion.

    Parameters
    ----------
    scene : Scene
    step : float, s
    limit : (m,) effort limits, N m or N
    """

    def __init__(self, scene: Scene, step: float, limit: np.ndarray) -> None:
        self.scene, self.step_size, self.limit = scene, step, limit
        names = scene.joint_names
        self._active = [
            (f, first_step(f.start, step), math.inf if f.end is None else first_step(f.end, step))
            for f in scene.faults
        ]
        self._mask = [
            np.array([f.joints is None or name in f.joints for name in names]) for f in scene.faults
        ]
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        m = len(self.limit)
        self._step = 0
        self._random = [np.random.default_rng([self.scene.seed, k]) for k in range(len(self.scene.faults))]
        self._number = itertools.count()
        # commands on their way: step due, whether a copy, number, torque
        self._line: list[tuple[int, bool, int, np.ndarray]] = []
        self._last_due = 0
        self._wanted = np.zeros(m)  # the torque that has arrived
        self._lagged = np.zeros(m)  # what the motors gave at the start of this step
        self._after = np.zeros(m)  # and at its end
        self._frozen: dict[tuple[int, str], np.ndarray] = {}
        self._measured: dict[str, tuple[int, np.ndarray]] = {}

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
            (k, f) for k, (f, start, end) in enumerate(self._active) if start <= n < end and f.kind in kinds
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
        self._last_due = max(self._last_due, math.ceil(due - 1e-6))
        for late in (0.0, *copies):
            arrival = math.ceil(self._last_due + late - 1e-6)
            copied = late > 0.0  # and behind what arrives with it, or nobody would notice
            heapq.heappush(self._line, (arrival, copied, next(self._number), torque.copy()))

    def drive(self, torque: np.ndarray) -> None:
        """Write what the motors give at start, middle and end of the coming step into torque (3, m)."""
        while self._line and self._line[0][0] <= self._step:
            self._wanted = heapq.heappop(self._line)[-1]
        torque[:] = np.clip(self._wanted, -self.limit, self.limit)
        h = self.step_size
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

    def advance(self) -> None:
        """The step has been taken."""
        self._step += 1
        self._lagged[:] = self._after

    @property
    def step(self) -> int:
        """Steps since the first state."""
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
                random = np.random.default_rng([self.scene.seed, k, self._step])
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


def payload_scenes(scene: Scene, step: float) -> list[tuple[int, Scene]]:
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
        found.append((first_step(time, step), scene.model_copy(update={"links": links})))
    return found
