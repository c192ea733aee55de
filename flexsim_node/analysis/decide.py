"""What a scene leaves to `auto`, decided against its tolerance: the formulation, then the effects."""

from __future__ import annotations

from functools import lru_cache

from ..motion.decision import Change, Chosen, Decision
from ..motion.envelope import common, hull
from ..motion.faults import payload_scenes
from ..scene.schema import Scene
from ..scene.variants import opened, with_effect
from .effects import Drive, Trial, envelope_trials, without_meaning
from .formulations import choose_formulation

SHARE = 0.5  # of the tolerance that what is left out may change: between the envelope's runs it may be more


def resolve_effects(
    scene: Scene, drive: Drive = None, duration: float | None = None, tolerance: float | None = None
) -> Decision:
    """Decide what a scene leaves open by what it changes at the tip.

    First the formulation (see choose_formulation).  Then each open effect is measured alone, on the scene's
    motion and on the widest of its envelope (see envelope_trials); then, the least important first, as many
    are left out as together stay within SHARE of the tolerance over the whole envelope, less what the
    formulation takes of it.  A scene at rest decides nothing.  The scene's own torque profile drives the
    runs unless `drive` does.  The same scene always gets the same decision.

    Raises
    ------
    ArithmeticError
        where the scene does not run with all of them on
    """
    if drive is None and duration is None and tolerance is None:
        return _resolved(scene.model_dump_json())
    return _resolve(scene, drive, duration, tolerance)


def decided(scene: Scene) -> Scene:
    """The scene with all that it leaves open decided."""
    return resolve_effects(scene).scene if scene.undecided else scene


def decide(scene: Scene) -> tuple[Scene, Decision | None]:
    """A scene to be run, decided with the payloads that its faults bring from the start, and how it was.

    None where it leaves nothing open.
    """
    if not scene.undecided:
        return scene, None
    decision = resolve_effects(payload_scenes(scene, scene.solver.step)[0][1])
    return scene.model_copy(update=opened(decision.scene)), decision


@lru_cache(maxsize=64)
def _resolved(text: str) -> Decision:
    return _resolve(Scene.model_validate_json(text), None, None, None)


def _resolve(scene: Scene, drive: Drive, duration: float | None, tolerance: float | None) -> Decision:
    limit = scene.tolerance if tolerance is None else tolerance
    assert limit is not None or not scene.undecided  # the schema sees to it
    limit = limit or 0.0
    if scene.formulation != "auto":
        return _resolve_effects(scene, drive, duration, limit, None)
    chosen = choose_formulation(scene, SHARE * limit, limit, drive, duration)
    return _resolve_effects(chosen.scene, drive, duration, limit, chosen)


def _resolve_effects(
    scene: Scene, drive: Drive, duration: float | None, limit: float, chosen: Chosen | None
) -> Decision:
    """The decision of the open effects, in the scene's formulation."""
    open_effects = scene.effects.undecided
    seen = None if chosen is None else chosen.envelope
    if not open_effects:
        at_rest = chosen is not None and chosen.at_rest
        return Decision(scene, limit, (), (), 0.0, seen, at_rest, chosen)
    own = Trial(scene, drive, duration)
    absent = without_meaning(own.scene)
    if own.at_rest(limit):
        changes = sorted((own.change(n) for n in open_effects), key=lambda c: (c.change, c.name))
        return Decision(own.scene, limit, tuple(changes), (), 0.0, seen, at_rest=True, chosen=chosen)
    trials = envelope_trials(scene, own, scene.auto.margin) or [own]
    found = []
    for name in open_effects:
        if name in absent:
            found.append(Change(name, True, 0.0, 0.0))
            continue
        several = [own.change(name), trials[0].change(name)]
        found.append(max(several, key=lambda c: c.change))
    changes = sorted(found, key=lambda c: (c.change, c.name))
    allowed = SHARE * limit - (0.0 if chosen is None else chosen.off)
    out = [c.name for c in changes if c.change <= allowed and _may_go(c.name, own.scene, chosen)]
    decided, together = own.scene, 0.0
    while out:
        tried = own.scene
        for name in out:
            tried = with_effect(tried, name, False)
        together = 0.0
        for trial in [own, *trials] if set(out) - absent else []:
            together = max(together, trial.distance(tried)[0])
            if together > allowed:
                break
        if together <= allowed:
            decided = tried
            break
        together = 0.0
        out.pop()
    missing = tuple(n for n in reversed(out) if n not in absent)
    if missing:
        joints, motions = scene.joint_names, [t.motion for t in (own, *trials)]
        longest = max(t.duration for t in (own, *trials))
        seen = common(hull(joints, motions, longest, missing), seen)
    return Decision(decided, limit, tuple(changes), tuple(out), together, seen, chosen=chosen)


def _may_go(name: str, scene: Scene, chosen: Chosen | None) -> bool:
    """Whether an effect may be left out: not the damping without which `auto` would not have taken erls."""
    roots = scene.formulation == "erls" and scene.erls.zeroed == "root"
    return not (name == "damping" and chosen is not None and roots)
