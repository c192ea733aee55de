"""How far the formulations are apart on a scene, and the cheaper of those that hold: `formulation: auto`."""

from __future__ import annotations

from ..model.dofs import is_planar
from ..motion.decision import Apart, Chosen, millimetres
from ..motion.envelope import hull
from ..scene.schema import Erls, Scene
from ..scene.variants import elements, everything_open_on, finer, in_formulation, more_elements
from .effects import Drive, Trial, envelope_trials

DOUBLINGS = 2  # of elements and steps, at most, until their part in a distance no longer decides
MOST_ELEMENTS = 16  # a link, to which that goes

CO_MOVING_UP_TO = {
    ("rosenbrock_w", "chord"): (1, 1),
    ("rosenbrock_w", "root"): (2, 4),
    ("generalized_alpha", "chord"): (4, 4),
    ("generalized_alpha", "root"): (2, 4),
    ("runge_kutta_4", "chord"): (4, 4),
    ("runge_kutta_4", "root"): (2, 2),
}
"""Elements a link up to which co-moving frames are the cheaper ones, in the plane and in space."""
IN_LOOPS = 2  # at least, where loops close the robot: closing costs both the same
WITH_ALPHA = 1  # at most, where Rayleigh's alpha damps the elastic velocity: it costs co-moving frames more


def unknown(own: str, other: str, why: str) -> Apart:
    """A distance that isn't known."""
    return Apart(own, other, float("nan"), float("nan"), why)


def formulations_apart(scene: Scene, drive: Drive = None, duration: float | None = None) -> Apart:
    """Measure how far the other formulation's tips are from the scene's on its own motion.

    What is the mesh's and the step's is no matter of the formulation: it is told as `unsure`.

    Raises
    ------
    ArithmeticError
        where the scene itself does not run to its end
    """
    own = everything_open_on(scene)
    other = "erls" if own.co_moving else "co_moving"
    try:
        changed = in_formulation(own, other)
    except ValueError as problem:
        return unknown(own.formulation, other, str(problem))
    return distance_of(Trial(own, drive, duration), changed, 1)


def distance_of(trial: Trial, changed: Scene, doublings: int, allowed: float | None = None) -> Apart:
    """How far a trial's run is from that of its scene in another formulation.

    Elements and steps are doubled once, and then until that no longer decides whether the distance is
    within `allowed` (m), `doublings` times at most.
    """
    own, other = trial.scene.formulation, changed.formulation
    last, trouble = trial.distance(changed)
    distance, unsure, times = last, 0.0, 1
    if elements(changed) == 0 or trouble:
        doublings = 0
    for n in range(doublings):
        times *= 2
        if n > 0 and times * elements(changed) > MOST_ELEMENTS:
            break
        try:
            fine = trial.of(finer(trial.scene, times))
        except ArithmeticError as problem:
            return unknown(own, other, f"in {own} with {times} times the elements and steps, {problem}")
        distance, trouble = fine.distance(finer(changed, times))
        unsure, last = abs(distance - last), distance
        if trouble or allowed is None or not distance - unsure <= allowed < distance + unsure:
            break
    if trouble:
        return unknown(own, other, f"in {other} the run {trouble}")
    return Apart(own, other, distance, unsure)


def choose_formulation(
    scene: Scene, allowed: float, tolerance: float, drive: Drive = None, duration: float | None = None
) -> Chosen:
    """Take the cheaper of the formulations that stay within `allowed` (m) over a scene's envelope.

    Co-moving frames hold however far links turn, so that they stand for the truth.  The ERLS is run beside
    them, everything on, on the scene's own motion and on its envelope (envelope_trials).  Where co-moving
    frames are the cheaper ones (cheaper_co_moving) they are taken, unless twice the elements change them by
    more than `allowed` and the ERLS by less.

    Nothing depends on a clock: the same scene always gets the same formulation.

    Parameters
    ----------
    tolerance : m; tips that move less are at rest, which decides nothing

    Raises
    ------
    ArithmeticError
        where the scene runs in neither
    """
    erls = in_formulation(scene, "erls")
    try:
        moving = in_formulation(scene, "co_moving")
    except ValueError as problem:
        return Chosen(erls, f"how far it is off isn't known, for {problem}")
    linear = everything_open_on(erls)
    swings = swinging_roots(linear)
    if swings:
        return Chosen(moving, swings)
    try:
        own = Trial(moving, drive, duration)
    except ArithmeticError as problem:
        Trial(erls, drive, duration)
        return Chosen(erls, f"how far it is off isn't known: in co_moving frames {problem}")
    if own.at_rest(tolerance):
        why = "the tips move by less than the tolerance, which decides nothing, and this one is exact"
        return Chosen(moving, why, at_rest=True)
    trials = [*envelope_trials(moving, own, scene.auto.margin), own]
    limit = f"{millimetres(allowed)} that the tolerance leaves"
    mesh = ""
    if cheaper_co_moving(linear):
        change = max(twice_the_elements(trial, moving) for trial in trials)
        same = change > allowed and max(twice_the_elements(trial, linear) for trial in trials) > allowed
        if change <= allowed or same:
            coarse = f"; but twice the elements change either by {millimetres(change)} or so" if same else ""
            return Chosen(moving, f"the cheaper one, and exact however far links turn{coarse}")
        mesh = f"; the cheaper co_moving needs more elements: twice as many change {millimetres(change)}"
    worst = Apart("co_moving", "erls", 0.0, 0.0)
    for trial in trials:
        found = distance_of(trial, linear, DOUBLINGS, allowed)
        if not found.most <= worst.most:
            worst = found
        if not worst.most <= allowed:
            if worst.refused:
                return Chosen(moving, f"erls does not go as far: {worst.refused}", worst)
            beyond = "perhaps beyond" if worst.distance - worst.unsure <= allowed else "beyond"
            return Chosen(
                moving, f"erls is {said(worst)} in a run of the envelope, {beyond} the {limit}", worst
            )
    longest = max(trial.duration for trial in trials)
    seen = hull(scene.joint_names, [trial.motion for trial in trials], longest, (), "erls")
    why = f"it is {said(worst)} at most over the envelope, within the {limit}"
    return Chosen(erls, f"{why}{mesh}" if mesh else f"the cheaper one: {why}", worst, seen)


def said(apart: Apart) -> str:
    """How far the formulations are apart, in words."""
    return f"{millimetres(apart.distance)} ± {millimetres(apart.unsure)} from {apart.own}"


def twice_the_elements(trial: Trial, scene: Scene) -> float:
    """m that twice the elements change in a trial's run of a scene; infinite where it has none."""
    try:
        run = trial if scene.formulation == trial.scene.formulation else trial.of(scene)
        return run.distance(more_elements(run.scene, 2))[0]
    except ArithmeticError:
        return float("inf")


def cheaper_co_moving(scene: Scene) -> bool:
    """Whether a step costs less in co-moving frames than in the ERLS, by what the scene is made of.

    By the integrator, the zeroed dofs, plane or space, loops, alpha, and the mean number of elements of the
    links that bend; measured with benchmarks/formulation_cost.py.  Adaptive methods were not: there the ERLS
    counts as the cheaper one.
    """
    bending = [k.beam.elements for k in scene.links if k.beam is not None and k.flexible]
    zeroed = "root" if scene.erls.zeroed == "root" else "chord"
    plane, space = CO_MOVING_UP_TO.get((scene.solver.method, zeroed), (0, 0))
    most = plane if is_planar(scene) else space
    if scene.loops and most > 0:
        most = max(most, IN_LOOPS)
    if scene.effects.damping and scene.damping.alpha > 0.0 and scene.damping.alpha_form == "elastic":
        most = min(most, WITH_ALPHA)
    return bool(bending) and sum(bending) <= most * len(bending)


def swinging_roots(scene: Scene) -> str:
    """Why `auto` does not take the ERLS, whatever a run says, or "".

    With the roots' rotations zeroed q swings with the elastic modes; undamped, fine steps resolve them, and
    the ERLS is then off by many times the squared elastic rotation.
    """
    damped = scene.effects.damping and (scene.damping.alpha > 0.0 or scene.damping.beta > 0.0)
    if scene.erls == Erls(zeroed="root") and not damped and elements(scene) > 0:
        return (
            "erls with zeroed: root and without damping is off at fine steps, where q swings with the elastic"
            " modes; give erls.zeroed: auto, or damping, for erls to be thought of"
        )
    return ""
