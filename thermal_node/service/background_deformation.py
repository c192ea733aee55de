"""The deformation in a thread of its own, so that the march never waits for it."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from ..deformation.deflection import Deflection
from ..deformation.leaf import Deformation
from ..heat.conduction import Array
from ..model.door_model import DoorModel


@dataclass(frozen=True)
class Bent:
    """A solved shape: when, s of exposure and stamp in ns, and the whole leaf's nodes (N, 3), m."""

    time: float
    stamp: int
    deflection: Deflection
    whole: Array


class BackgroundDeformation:
    """Solves the latest temperatures that it was given, then the latest again.

    Raises SceneError where the scene says too little for a deformation.
    """

    def __init__(self, model: DoorModel) -> None:
        self._deformation = Deformation(model)
        self._latest: tuple[int, float, int, Array] | None = None
        self._done: Bent | None = None
        self._generation = 0
        self._lock = threading.Lock()
        self._asked = threading.Event()
        self._stop = False
        self._thread = threading.Thread(target=self._run, name="deformation", daemon=True)
        self.solved = 0
        self.skipped = 0
        self.failure = ""

    def start(self) -> None:
        """Begin to wait for temperatures."""
        self._thread.start()

    def stop(self) -> None:
        """Take up no more; the solution in progress is not waited for long."""
        self._stop = True
        self._asked.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def submit(self, time: float, stamp: int, temperature: Array) -> None:
        """Ask for the shape at these node temperatures; one that waits is forgotten."""
        with self._lock:
            self.skipped += self._latest is not None
            self._latest = (self._generation, time, stamp, temperature.copy())
            self._asked.set()

    def forget(self) -> None:
        """Forget what was asked and what is solved: the test begins anew."""
        with self._lock:
            self._generation += 1
            self._latest = self._done = None

    def take(self) -> Bent | None:
        """A shape that was not taken yet, or None."""
        with self._lock:
            found, self._done = self._done, None
            return found

    def _run(self) -> None:
        before: Deflection | None = None
        last = -1
        while True:
            self._asked.wait()
            if self._stop:
                return
            with self._lock:
                self._asked.clear()
                work, self._latest = self._latest, None
            if work is None:
                continue
            generation, time, stamp, temperature = work
            if generation != last:
                before, last = None, generation  # the test began anew, with a leaf that never yielded
            try:
                deflection = self._deformation.solve(temperature, before)
                whole = self._deformation.whole()
            except Exception as problem:  # the march goes on without a shape, and says so
                self.failure = f"at {time:.1f} s: {problem}"
                continue
            if not (np.isfinite(whole).all() and np.isfinite(deflection.bow)):
                self.failure = f"at {time:.1f} s: the shape is not finite"
                continue
            before = deflection
            with self._lock:
                self.solved += 1
                self.failure = ""
                if generation == self._generation:
                    self._done = Bent(time, stamp, deflection, whole)
