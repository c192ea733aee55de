"""What each effect changes at the tip: measured on the scene itself, and decided against its tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .schema import HELD_BY_FRAMES, Effects, Scene
from .torque_profile import torque_profile

SAMPLES = 400  # of a run's tip
Drive = Callable[[float], np.ndarray] | None


@dataclass(frozen=True)
class Change:
    """What switching one effect does to a scene's run.

    Attributes
    ----------
    name : of the effect, or `flexible: LINK`
    on : whether the scene has it; the other way round is what is measured
    change : m, the largest distance of a tip from itself at one time; infinite where the other run fails
    relative : change over the tip's own largest distance from where it starts
    trouble : why the other way can't run, or ""
    """

    name: str
    on: bool
    change: float
    relative: float
    trouble: str = ""


@dataclass(frozen=True)
class Decision:
    """Which of the effects that a scene leaves open (`auto`) are simulated, and why.

    Attributes
    ----------
    scene : every effect decided
    tolerance : m at the tip
    changes : of every open effect alone, the smallest first
    left_out : those that are off; together : m that they change together
    """

    scene: Scene
    tolerance: float
    changes: tuple[Change, ...]
    left_out: tuple[str, ...]
    together: float

    def sentences(self) -> list[str]:
        """A line for each open effect, and one for all that are left out."""
        lines = [
            f"{c.name}: {'off' if c.name in self.left_out else 'on'},"
            f" without it the tip is {millimetres(c.change)} off" + (f" ({c.trouble})" if c.trouble else "")
            for c in self.changes
        ]
        what = ", ".join(self.left_out) or "nothing"
        lines.append(
            f"left out: {what}; together {millimetres(self.together)} of {millimetres(self.tolerance)}"
        )
        return lines


def millimetres(length: float) -> str:
    """A length in words."""
    return f"{1e3 * length:.3g} mm" if np.isfinite(length) else "without bound"


def effect_names() -> tuple[str, ...]:
    """Names of all effects."""
    return tuple(Effects.model_fields)


def with_effect(scene: Scene, name: str, on: bool) -> Scene:
    """The scene with one effect, or one link's flexibility (`flexible: LINK`), switched."""
    kind, _, link = name.partition(": ")
    if link:
        links = tuple(k.model_copy(update={"flexible": on}) if k.name == link else k for k in scene.links)
        return scene.model_copy(update={"links": links})
    return scene.model_copy(update={"effects": scene.effects.model_copy(update={kind: on})})


def is_on(scene: Scene, name: str) -> bool:
    """Whether an effect, or a link's flexibility, is on; what is open counts as on."""
    kind, _, link = name.partition(": ")
    if link:
        return next(k.flexible for k in scene.links if k.name == link)
    return getattr(scene.effects, kind) is not False


def everything_open_on(scene: Scene) -> Scene:
    """The scene with its open effects on: what the others are compared with."""
    for name in scene.effects.undecided:
        scene = with_effect(scene, name, True)
    return scene


class Trial:
    """The run of a scene that its effects are judged by.

    Parameters
    ----------
    drive : torque (m,) as a function of time; the scene's own profile where None
    duration : s; the scene's own where None

    Raises
    ------
    ArithmeticError
        where the scene itself does not run to the end
    """

    def __init__(self, scene: Scene, drive: Drive = None, duration: float | None = None) -> None:
        self.scene = everything_open_on(scene)
        self.drive = drive or torque_profile(scene)
        self.duration = scene.duration if duration is None else duration
        self.path, trouble = self._tip(self.scene)
        if trouble:
            raise ArithmeticError(f"{scene.name}: the run that effects are judged by {trouble}")
        self.reach = float(np.max(np.linalg.norm(self.path - self.path[0], axis=-1)))

    def _tip(self, scene: Scene) -> tuple[np.ndarray, str]:
        """Paths (K, tips, 3) of the tips, and why they ended early, or ""."""
        from .simulate import simulate  # which builds models, which may ask for decisions

        period = max(scene.solver.step, self.duration / SAMPLES)
        try:
            run = simulate(scene, self.drive or _no_torque(scene), self.duration, sample_period=period)
        except (ValueError, ArithmeticError) as problem:
            return np.zeros((0, 1, 3)), f"can't be simulated: {problem}"
        return run.link_end[:, list(scene.tips)], "" if run.status == "ok" else run.status

    def distance(self, scene: Scene) -> tuple[float, str]:
        """Largest distance, m, of the tip from that of the trial's own run; infinite with a reason."""
        path, trouble = self._tip(scene)
        if trouble:
            return float("inf"), trouble
        return float(np.max(np.linalg.norm(path - self.path, axis=-1))), ""

    def change(self, name: str) -> Change:
        """What switching one effect, or one link's flexibility, does."""
        on = is_on(self.scene, name)
        if self.scene.formulation == "co_moving" and name in HELD_BY_FRAMES:
            trouble = "can't be simulated: co-moving frames hold it by their geometry"
            return Change(name, on, float("inf"), float("inf"), trouble)
        change, trouble = self.distance(with_effect(self.scene, name, not on))
        return Change(name, on, change, change / self.reach if self.reach > 0.0 else 0.0, trouble)


def _no_torque(scene: Scene) -> Callable[[float], np.ndarray]:
    zero = np.zeros(len(scene.joints))
    return lambda t: zero


def resolve_effects(
    scene: Scene, drive: Drive = None, duration: float | None = None, tolerance: float | None = None
) -> Decision:
    """Decide the effects that a scene leaves open by what leaving them out changes at the tip.

    Each is measured alone; then, the least important first, as many are left out as stay within the tolerance
    together.  The scene's own torque profile drives the run unless `drive` does.  The same scene always gets
    the same decision.

    Raises
    ------
    ArithmeticError
        where the scene does not run with all of them on
    """
    if drive is None and duration is None and tolerance is None:
        return _resolved(scene.model_dump_json())
    return _resolve(scene, drive, duration, tolerance)


@lru_cache(maxsize=64)
def _resolved(text: str) -> Decision:
    return _resolve(Scene.model_validate_json(text), None, None, None)


def _resolve(scene: Scene, drive: Drive, duration: float | None, tolerance: float | None) -> Decision:
    open_effects = scene.effects.undecided
    limit = scene.tolerance if tolerance is None else tolerance
    assert limit is not None or not open_effects  # the schema sees to it
    limit = limit or 0.0
    if not open_effects:
        return Decision(scene, limit, (), (), 0.0)
    trial = Trial(scene, drive, duration)
    changes = sorted((trial.change(name) for name in open_effects), key=lambda c: (c.change, c.name))
    left_out: list[str] = []
    decided, together = trial.scene, 0.0
    for change in changes:
        if change.change > limit:
            break
        tried = with_effect(decided, change.name, False)
        distance, _ = trial.distance(tried) if left_out else (change.change, "")
        if distance <= limit:
            decided, together = tried, distance
            left_out.append(change.name)
    return Decision(decided, limit, tuple(changes), tuple(left_out), together)
