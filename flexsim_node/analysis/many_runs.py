"""What simulate_many's threads do: runs one after the other, each as motion/run.py makes it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..integrators import METHODS
from ..motion.decision import Decision
from ..motion.jumps import Jumps, torque_jumps
from ..motion.law import CompiledLaw
from ..motion.marcher import Marching, Tapes
from ..motion.run import Torque, check_times, run
from ..motion.samples import JOINTS, PLACES, Samples
from ..motion.validity import NAMES
from ..scene.load import Scene, SceneError
from ..scene.torque_profile import torque_profile
from ..scene.variants import opened
from .decide import decide

OUTPUTS = (*JOINTS, "torque", *PLACES, "energy", "sensors")


@dataclass(frozen=True)
class Runs:
    """What many simulations gave; R robots, K samples.  Past a robot's last sample its rows are NaN.

    Attributes
    ----------
    time : (K,) s
    outputs : name to (R, K, ...), those that were asked for; each is an attribute too, as of Run
    samples : (R,) how many each robot has
    status : (R,) "ok", or the reason why the run ended before its time
    validity : name of each figure of the validity watch to its largest, (R,)
    warnings : (R,) what passed a limit without ending the run, a sentence each
    sensors : name of each sensor to its readings (R, K, ...), where they were asked for
    """

    time: np.ndarray
    outputs: dict[str, np.ndarray]
    samples: np.ndarray
    status: tuple[str, ...]
    validity: dict[str, np.ndarray]
    warnings: tuple[tuple[str, ...], ...]
    sensors: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.status)

    def __getattr__(self, name: str) -> np.ndarray:
        if name in OUTPUTS:
            if name in self.outputs:
                return self.outputs[name]
            raise AttributeError(f"{name} was not kept; name it in simulate_many(..., outputs=...)")
        raise AttributeError(f"Runs has no {name}")


@dataclass(frozen=True)
class Feedback:
    """A law, and what each robot's gets: given (R, g), and `memory` numbers of its own."""

    law: CompiledLaw
    given: np.ndarray
    memory: int


class Plan:
    """When steps, samples and a law's answers are.

    Attributes
    ----------
    times : (K,) s of the samples
    period : s between them
    substeps : steps from one to the next, `control` of them from answer to answer
    step : s
    """

    def __init__(
        self,
        scene: Scene,
        duration: float,
        sample_period: float | None,
        control_period: float | None,
    ) -> None:
        own = scene.solver.step
        self.period = own if sample_period is None else float(sample_period)
        answer = self.period if control_period is None else float(control_period)
        check_times(duration, sample_period=self.period, control_period=answer)
        answers = round(self.period / answer)
        if answers < 1 or abs(answers * answer - self.period) > 1e-9 * self.period:
            raise ValueError(
                f"sample_period {self.period:g} s is no whole multiple of control_period {answer:g} s;"
                " give one"
            )
        self.control = max(1, int(np.ceil(self.period / answers / own - 1e-9)))
        self.substeps = answers * self.control
        self.step = self.period / self.substeps
        self.times = self.period * np.arange(int(np.floor(duration / self.period + 1e-9)) + 1)
        self.duration = duration


class Work:
    """The runs that are asked for, and where their results go."""

    def __init__(
        self,
        plan: Plan,
        scenes: list[Scene],
        torque: Torque,
        jumps: tuple[float, ...],
        outputs: tuple[str, ...],
        feedback: Feedback | None = None,
    ) -> None:
        self.plan, self.scenes, self.torque, self.jumps = plan, scenes, torque, jumps
        self.outputs, self.feedback = outputs, feedback
        for k, scene in enumerate(scenes):
            if scene.solver.step != scenes[0].solver.step:
                raise ValueError(
                    f"robot {k} has solver.step {scene.solver.step:g} s, robot 0 {scenes[0].solver.step:g} s;"
                    " give all the same"
                )
            if feedback is not None and (why := self.by_hand(scene)):
                raise ValueError(f"robot {k}: {scene.name}: no law can drive {why} yet; give torques instead")
        self.lock = threading.Lock()
        self.next, self.done, self.stopped = 0, 0, False
        self.found: dict[str, np.ndarray] = {}
        self.sensors: dict[str, np.ndarray] = {}
        self.samples = np.zeros(len(scenes), dtype=np.int64)
        self.validity = np.zeros((len(scenes), len(NAMES)))
        self.status = [""] * len(scenes)
        self.warnings: list[tuple[str, ...]] = [()] * len(scenes)

    def by_hand(self, scene: Scene) -> str:
        """Why Python has to take a scene's steps, or ""."""
        if scene.faults:
            return "a robot with faults"
        if scene.loops:
            return "a robot with loops"
        if scene.solver.method not in METHODS:
            return f"steps of {scene.solver.method}"
        if "sensors" in self.outputs and scene.sensors:
            return "a robot whose sensors are read"
        return ""

    def tapes(self) -> Tapes:
        """Pieces of runs, for one thread."""
        return Tapes(self.plan.times, self.plan.period, self.plan.substeps, self.plan.step)

    def run(self, threads: int, progress: Callable[[int, int], None] | None) -> Runs:
        """Make all runs."""
        with ThreadPoolExecutor(min(threads, len(self.scenes))) as pool:
            workers = [pool.submit(self.worker, progress) for _ in range(min(threads, len(self.scenes)))]
            try:
                for worker in workers:
                    worker.result()
            finally:
                self.stopped = True
        return Runs(
            self.plan.times, self.found, self.samples, tuple(self.status),
            {name: self.validity[:, k] for k, name in enumerate(NAMES)}, tuple(self.warnings), self.sensors,
        )  # fmt: skip

    def worker(self, progress: Callable[[int, int], None] | None) -> None:
        """Make runs until none is left; one thread of them."""
        bench = Bench(self)
        while True:
            with self.lock:
                k = self.next
                if self.stopped or k == len(self.scenes):
                    return
                self.next += 1
            try:
                bench.make(k)
            except SceneError as problem:
                self.stopped = True
                raise SceneError(f"robot {k}: {problem}") from None
            except (ValueError, ArithmeticError) as problem:
                self.stopped = True
                raise type(problem)(f"robot {k}: {problem}") from None
            except BaseException:
                self.stopped = True
                raise
            if progress is not None:
                with self.lock:
                    self.done += 1
                    progress(self.done, len(self.scenes))

    def keep(
        self, k: int, values: Mapping[str, np.ndarray], sensors: Mapping[str, np.ndarray], kept: int,
        status: str, validity: np.ndarray, warnings: tuple[str, ...],
    ) -> None:  # fmt: skip
        """Write down what robot k's run gave."""
        for table, new in ((self.found, values), (self.sensors, sensors)):
            for name, value in new.items():
                with self.lock:
                    if name not in table:
                        table[name] = np.full(
                            (len(self.scenes), len(self.plan.times), *value.shape[1:]), np.nan
                        )
                if table[name].shape[2:] != value.shape[1:]:
                    raise ValueError(
                        f"its {name} has shape {value.shape[1:]} a sample, another robot's"
                        f" {table[name].shape[2:]}; leave {name} out of outputs, or simulate them apart"
                    )
                table[name][k, :kept] = value[:kept]
        self.samples[k], self.status[k], self.validity[k], self.warnings[k] = kept, status, validity, warnings


class Bench:
    """What one thread makes runs with: the last robot that it built, and its torques."""

    def __init__(self, work: Work) -> None:
        self.work, self.tapes = work, work.tapes()
        self.marching: Marching | None = None
        self.samples: Samples | None = None

    def make(self, k: int) -> None:
        """Make the run of robot k."""
        work, feedback = self.work, self.work.feedback
        scene, torque = work.scenes[k], work.torque
        if torque is not None and not callable(torque):
            torque = np.asarray(torque, dtype=float)
            torque = torque[k] if torque.ndim == 3 else torque
        _, decision = decide(scene)
        if work.by_hand(scene):
            self.by_hand(k, torque, decision)
            return
        marching, samples = self.take(scene, decision)
        if feedback is None:
            profile = torque_profile(scene) if torque is None else torque
            cuts = Jumps([*work.jumps, *(torque_jumps(scene) if torque is None else ())])
            tape, law = marching.driven(
                self.tapes.of(cuts), profile, scene.torque if torque is None else torque
            )
        else:
            tape = self.tapes.of(Jumps(), work.plan.control)
            law = marching.fed_back(feedback.law.address, feedback.given[k], feedback.memory)
        try:
            made = marching.run(tape, law)
        except IndexError as problem:  # nothing but a law looks at what may not be there
            raise ValueError(f"the law reads or writes beyond one of its arrays: {problem}") from None
        if made.left and scene.auto.beyond == "switch_on":
            self.by_hand(k, torque, decision)
            return
        values = samples.read(marching.record.states, made.kept)
        if "torque" in work.outputs:
            values["torque"] = marching.torques(law, made.kept)
        work.keep(k, values, {}, made.kept, made.status, made.validity, made.warnings)

    def take(self, scene: Scene, decision: Decision | None) -> tuple[Marching, Samples]:
        """The robot of a scene at its start, built only where the last one was another."""
        closed = scene if decision is None else scene.model_copy(update=opened(decision.scene))
        envelope = None if decision is None else decision.envelope
        if self.marching is not None and self.samples is not None and self.marching.goes_on(closed, envelope):
            return self.marching, self.samples
        self.marching = Marching(closed, self.tapes, envelope)
        self.samples = Samples(self.marching.robot, self.work.outputs)
        return self.marching, self.samples

    def by_hand(self, k: int, torque: Torque, decision: Decision | None) -> None:
        """Make a run with steps from Python."""
        work, plan = self.work, self.work.plan
        made = run(work.scenes[k], torque, plan.duration, plan.period, jumps=work.jumps, decision=decision)
        kept = {name: getattr(made, name) for name in work.outputs if name != "sensors"}
        sensors = made.sensors if "sensors" in work.outputs else {}
        validity = np.array([made.validity[name] for name in NAMES])
        work.keep(k, kept, sensors, len(made.time), made.status, validity, made.warnings)
