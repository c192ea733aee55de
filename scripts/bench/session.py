"""Controllers on the bench: the nominal run, the other cases, and the delay that each bears."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexsim_node import Scene

from ..controller.trajectory import Trajectory
from .cases import Case, cases, latency
from .rig import Rig
from .score import Recording, Score, score

DELAYS = (1, 2, 4, 8, 16, 32, 64)  # periods
TRIES = 3  # of a run of which states are lost on their way
NOMINAL = Case("nominal", "nothing in its way")


@dataclass(frozen=True)
class Delay:
    """The longest delay that a controller bore, the shortest at which it was lost, s, and why it was."""

    borne: float
    lost: float | None = None
    reason: str = ""


class Session:
    """Judges controllers on one rig, all of them on the same cases.

    Attributes
    ----------
    recordings, scores : controller to case to what was done and how it is judged
    delays : controller to the longest delay that it bore and the shortest at which it was lost, s, and why
    about : what each case is
    """

    def __init__(
        self, rig: Rig, scene: Scene, wanted: Trajectory, settle: float, say: Callable[[str], None]
    ) -> None:
        self.rig, self.scene, self.wanted, self.say = rig, scene, wanted, say
        self.until = round((float(wanted.time[-1]) + settle) * rig.rate) / rig.rate
        self.recordings: dict[str, dict[str, Recording]] = {}
        self.scores: dict[str, dict[str, Score]] = {}
        self.delays: dict[str, Delay] = {}
        self.about = {NOMINAL.name: NOMINAL.about}
        self._planned: list[Case] = []

    def judge(self, controller: str, only: Sequence[str] = (), *, find_latency: bool = True) -> None:
        """Run a controller through all cases, or only those named.

        One whose nominal run has no end is spared the others, which would have none either.
        """
        self.recordings[controller], self.scores[controller] = {}, {}
        self._run(controller, NOMINAL)
        if self.recordings[controller][NOMINAL.name].trouble:
            return
        if not self._planned:
            # What a push or a weak motor is depends on what the first controller needs.
            effort = np.abs(self.recordings[controller][NOMINAL.name].effort).max(axis=0)
            planned = cases(self.scene, effort, float(self.wanted.time[-1]), 1.0 / self.rig.rate)
            self._planned = [case for case in planned if not only or case.name in only]
            self.about |= {case.name: case.about for case in self._planned}
        for case in self._planned:
            self._run(controller, case)
        if find_latency:
            self.delays[controller] = self._tolerance(controller)

    def _run(self, controller: str, case: Case) -> Score:
        self.say(f"{controller}: {case.name}")
        for _ in range(TRIES):
            run = self.rig.run(controller, case, self.wanted, self.until, self.scene)
            if not run.missing:
                break
            self.say(f"{controller}: {case.name}: {run.missing} states did not reach the bench; once more")
        else:
            raise RuntimeError(f"{run.missing} states did not reach the bench: the machine is too busy")
        self.recordings[controller][case.name] = run
        found = self.scores[controller][case.name] = score(run, self.wanted, self.until)
        if found.lost:
            self.say(f"{controller}: {case.name}: lost: {found.reason}")
        return found

    def _tolerance(self, controller: str) -> Delay:
        borne = 0.0
        for periods in DELAYS:
            delay = periods / self.rig.rate
            case = latency(delay)
            found = self._run(controller, case)
            del self.recordings[controller][case.name], self.scores[controller][case.name]
            if found.lost:
                return Delay(borne, delay, found.reason)
            borne = delay
        return Delay(borne)
