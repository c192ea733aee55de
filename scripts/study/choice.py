"""The frontier of a study, what to use for a budget or a tolerance, and writing that into the scene."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from .point import Measure, Outcome, Reference

UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6,
         "m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "K": 1.0}  # fmt: skip

LUCK = 1.5
"""A lasting error that is so many times a point's own is said."""


def quantity(text: str, units: tuple[str, ...]) -> float:
    """Read a number with one of these units, as 200us or 0.5mm, in SI units.

    Raises
    ------
    ValueError
    """
    match = re.fullmatch(r"\s*([0-9.eE+-]+?)\s*([a-zA-Zµμ]+)\s*", text)
    try:
        value = float(match[1]) if match and match[2] in units else math.nan
    except ValueError:
        value = math.nan
    if match is None or not value > 0.0 or not math.isfinite(value):
        raise ValueError(f"{text!r}; give a number and a unit, one of {', '.join(units)}")
    return value * UNITS[match[2]]


@dataclass(frozen=True)
class Cost:
    """What a point's time is judged by.

    rate : control periods a second that a robot has to keep up with, Hz; None for a door, whose time
        is that of the whole test
    """

    rate: float | None

    def of(self, outcome: Outcome) -> float:
        """Time, s: of one control period, with as many steps as it takes, or of a test."""
        if self.rate is None:
            return outcome.least
        if outcome.step is None:
            return outcome.least / self.rate
        steps = math.ceil(1.0 / (self.rate * outcome.step) - 1e-6)
        return steps * outcome.least * outcome.step

    def late(self, outcome: Outcome) -> float:
        """The time, s, that one control period in a hundred takes or more; of a test, its time."""
        return self.of(outcome) * (1.0 if self.rate is None else outcome.p99)

    def serves(self, outcome: Outcome) -> bool:
        """Whether it can answer at the rate: not with steps longer than a period, or of its own choice."""
        if self.rate is None:
            return True
        return outcome.step is not None and outcome.step * self.rate < 1.0 + 1e-6


def frontier(outcomes: Iterable[Outcome], measure: str, floor: float) -> list[Outcome]:
    """Those that nothing else beats in both time and error, cheapest first; effects do not compete.

    floor : errors below it are as good as it, because the reference tells no more
    """
    found: list[Outcome] = []
    able = (o for o in outcomes if o.ok and not o.effect and math.isfinite(o.error(measure)))
    for outcome in sorted(able, key=lambda o: o.median):
        if not found or max(outcome.error(measure), floor) < found[-1].error(measure):
            found.append(outcome)
    return found


@dataclass(frozen=True)
class Choice:
    """What to use, and why, in one sentence; outcome None where nothing will do.

    promise : the error to count on, the reference's own bound in it, SI units
    told : whether the study can tell at all
    """

    outcome: Outcome | None
    sentence: str
    promise: float = math.inf
    told: bool = True


def choose(
    outcomes: Iterable[Outcome],
    measure: Measure,
    cost: Cost,
    budget: float | None,
    tolerance: float | None,
    floor: float,
    truth: Truth | None = None,
) -> Choice:
    """The cheapest within a tolerance, or else the best within a budget; with both, within both.

    What counts is a point's promise: its lasting error, what the reference itself may be off, and how far
    its model is from the one that holds.  Where the reference is no better than the tolerance nothing is
    promised.

    budget : s for a control period (a robot) or a test (a door); tolerance : in SI units
    floor : the smallest error that the study can tell, SI units
    truth : what the reference may be off; it is exact where None
    """
    truth = truth or Truth({}, {})
    able = [o for o in outcomes if o.ok and not o.effect and math.isfinite(o.error(measure.name))]
    usable = [o for o in able if cost.serves(o)]
    lasting = {o.point: lasting_error(o, able, measure) for o in able}
    steps = {o.point: lasting[o.point] + truth.bound(o, measure) for o in able}
    # Where nothing of the model that holds was studied, what is promised is within the scene's own.
    strict = any(o.model == truth.holds for o in usable)
    promise = {o.point: steps[o.point] + strict * truth.model(o, measure) for o in able}
    asked = _asked(measure, cost, budget, tolerance)
    if not usable:
        return Choice(None, f"For {asked}: no point of the study ran to its end.")
    within = [o for o in usable if budget is None or cost.late(o) <= budget]
    exact = [o for o in within if tolerance is None or promise[o.point] <= tolerance]
    if tolerance is None and not any(math.isfinite(promise[o.point]) for o in usable):
        return Choice(None, f"For {asked} it can't be told: {truth.unsettled}.", told=False)
    if exact and tolerance is not None:
        best = min(exact, key=lambda o: (cost.of(o), promise[o.point]))
    elif exact:
        # Below the floor the study can't tell one from another: there, the cheaper.
        best = min(exact, key=lambda o: (max(promise[o.point], floor), cost.of(o)))
    elif tolerance is not None and (untold := _untold(usable, lasting, measure, tolerance, truth)):
        return Choice(None, f"For {asked} it can't be told: {untold}", told=False)
    elif within:
        best = min(within, key=lambda o: promise[o.point])
        enough = [o for o in usable if tolerance is None or promise[o.point] <= tolerance]
        needs = (
            f"that accuracy takes {duration_said(min(cost.late(o) for o in enough))}"
            if enough
            else "no point of the study is that accurate"
        )
        if not enough and tolerance is not None and any(steps[o.point] <= tolerance for o in usable):
            needs = f"{truth.model_said(measure)}, whatever the step"
        return Choice(
            None,
            f"For {asked} nothing will do: within the time, {use(best, measure, cost)} is the best; {needs}.",
        )
    else:
        best = min(usable, key=cost.late)
        return Choice(None, f"For {asked} nothing will do: the cheapest is {use(best, measure, cost)}.")
    sentence = f"For {asked}, use {use(best, measure, cost)}."
    if lasting[best.point] > LUCK * max(best.error(measure.name), floor):
        sentence += (
            f" Count on {measure.show(lasting[best.point])}: with smaller steps it is that far off, so that"
            " here the errors of step and mesh happen to oppose each other."
        )
    if truth.bounds:
        sentence += f" The reference is known to {measure.show(truth.bound(best, measure))}"
        far = truth.model(best, measure)
        if strict and far > 0.0:
            sentence += f", and {truth.model_said(measure)}"
        sentence += f": count on {measure.show(promise[best.point])}."
        if not strict and (far > 0.0 or truth.unknown):
            inside = f" That is within {best.model or 'this model'}: {truth.model_said(measure)}."
            much = tolerance is not None and promise[best.point] + far > tolerance
            sentence += inside + (
                " No step brings it within the tolerance of what that one says." if much else ""
            )
    return Choice(best, sentence, promise[best.point])


@dataclass(frozen=True)
class Truth:
    """What a reference may be off, and how far models are from the one that holds.

    bounds : {measure, or measure_model: bound on the reference's own error}, SI units
    models : {model: how far it is from the one that holds, at most}; holds : the name of that one
    rest : that of models which have no distance of their own, for they are held against one that has
    unknown : why the distance of models isn't known, or ""; finer : what would make the bounds smaller
    """

    bounds: Mapping[str, float]
    models: Mapping[str, float]
    holds: str = ""
    unknown: str = ""
    finer: str = ""
    rest: float = 0.0

    def bound(self, outcome: Outcome, measure: Measure) -> float:
        """Of the reference that this point is held against."""
        own = self.bounds.get(f"{measure.name}_{outcome.model}")
        return self.bounds.get(measure.name, 0.0) if own is None else own

    def model(self, outcome: Outcome, measure: Measure) -> float:
        """How far the point's model is from the one that holds, at most."""
        return 0.0 if outcome.model == self.holds else self.models.get(outcome.model, self.rest)

    def model_said(self, measure: Measure) -> str:
        """How far the models are, in words."""
        if self.unknown:
            return f"how far {self.unknown} isn't known"
        far = {n: measure.show(d) or "an unknown distance" for n, d in self.models.items() if d > 0.0}
        said = ", ".join(f"{n} up to {d}" for n, d in far.items())
        return f"{said} from {self.holds}, the model that holds further"

    @property
    def unsettled(self) -> str:
        """Why nothing can be told."""
        return (
            f"the reference has not settled; {self.finer}" if self.finer else "the reference has not settled"
        )


def _untold(
    usable: list[Outcome],
    lasting: Mapping[str, float],
    measure: Measure,
    tolerance: float,
    truth: Truth,
) -> str:
    """Why the study can't tell whether anything is within a tolerance, or ""."""
    strict = any(o.model == truth.holds for o in usable)
    least = {o.point: lasting[o.point] + strict * truth.model(o, measure) for o in usable}
    near = [o for o in usable if least[o.point] <= tolerance]
    if not near or any(least[o.point] + truth.bound(o, measure) <= tolerance for o in near):
        return ""
    bound = min(truth.bound(o, measure) for o in near)
    if not math.isfinite(bound):
        return f"{truth.unsettled}."
    what = f"the reference itself is known to {measure.show(bound)} only"
    return f"{what}. {truth.finer[:1].upper()}{truth.finer[1:]}." if truth.finer else f"{what}."


def lasting_error(outcome: Outcome, outcomes: Iterable[Outcome], measure: Measure) -> float:
    """The largest error of a point and of those on its curve with smaller steps.

    At some step the errors of step and mesh may cancel; another motion would not be so lucky.
    """
    finer = (o for o in outcomes if o.curve == outcome.curve and o.size <= outcome.size)
    return max(o.error(measure.name) for o in finer)


def _asked(measure: Measure, cost: Cost, budget: float | None, tolerance: float | None) -> str:
    parts = []
    if budget is not None and cost.rate is not None:
        parts.append(f"{rate_said(cost.rate)} with {budget * cost.rate:.0%} load ({duration_said(budget)})")
    elif budget is not None:
        parts.append(f"{duration_said(budget)} of processor time")
    elif cost.rate is not None:
        parts.append(rate_said(cost.rate))
    if tolerance is not None:
        parts.append(f"{measure.show(tolerance)} in {measure.label}")
    return " and ".join(parts) or "the least error"


def use(outcome: Outcome, measure: Measure, cost: Cost) -> str:
    """For example rosenbrock_w, 2 elements a link, step 1 ms: 0.02 mm, 30 µs of each 1 ms (3 %)."""
    step = f", step {duration_said(outcome.step)}" if outcome.step else f", tolerance {outcome.size:g}"
    took = cost.of(outcome)
    if cost.rate is None:
        time = f"{duration_said(took)} of processor time"
    else:
        time = f"{duration_said(took)} of each {duration_said(1.0 / cost.rate)} ({took * cost.rate:.1%}"
        time += f", p99 {duration_said(cost.late(outcome))})" if outcome.late else ")"
    return f"{outcome.curve}{step}: {measure.show(outcome.error(measure.name))}, {time}"


def formulations_said(
    own: str | None, others: Mapping[str, Mapping[str, Any]], measure: Measure
) -> list[str]:
    """How far the other formulations, or models, are, each in a sentence."""
    found = []
    for name, far in others.items():
        kind = "formulation" if "co_moving" in (name, own) else "model"
        if "refused" in far:
            found.append(f"How far {own} is from {name} isn't known: {far['refused']}")
            continue
        found.append(
            f"{name}, without error of step or mesh, is {measure.show(far['distance'])}"
            f" ± {measure.show(far['uncertainty'])} from {own}, this scene's {kind}: so far the models"
            " differ, whatever the step."
            + (
                " co_moving is the one that holds where links turn elastically."
                if "co_moving" in (name, own)
                else ""
            )
        )
    return found


def truth_of(own: str, reference: Reference, holds: str, together: bool) -> Truth:
    """What promises are measured by.

    own : the scene's model, which the reference is of; holds : the one that holds further than others
    together : whether points of any model are held against the reference, rather than against their own end
    """
    models: dict[str, float] = {}
    unknown = ""
    if own == holds and not together:
        # the others' points are held against their own ends: those are so far from this one
        for name, far in reference.formulations.items():
            if far.get("refused") != "nothing bends":
                models[name] = far["distance"] + far["uncertainty"] if "distance" in far else math.inf
    elif own != holds:
        far = reference.formulations.get(holds, {})
        if "distance" in far:
            models[own] = far["distance"] + far["uncertainty"]
        elif far and far.get("refused") != "nothing bends":
            unknown = f"{own} is from {holds}"
    rest = models.get(own, 0.0) if together else 0.0
    return Truth(reference.error, models, holds, unknown, reference.finer, rest)


def conditions_said(found: Mapping[str, Any], measure: Measure, cost: Cost) -> list[str]:
    """What the advice depends on, in sentences."""
    lines = []
    longer = found.get("longer", [])
    if len(longer) > 1:
        more = ", ".join(
            f"{duration_said(r['duration'])} {measure.show(r['error'])}" + _unsure(r, measure)
            for r in longer[1:]
        )
        lines.append(
            f"That holds for {duration_said(longer[0]['duration'])} of this motion"
            f" ({measure.show(longer[0]['error'])}); over longer runs: {more}."
        )
    if found.get("stopped"):
        lines.append(f"Over longer runs it can't be told: {found['stopped']}.")
    if found.get("nearby"):
        near = ", ".join(
            f"{name} {measure.show(r['error'])}" + _unsure(r, measure) for name, r in found["nearby"].items()
        )
        lines.append(f"On motions nearby: {near}.")
    if found.get("hopeless") is not None:
        lines.append(
            f"From {duration_said(found['hopeless'])} on no step helps: there, runs with the two smallest"
            " steps part by more than that; small causes grow too fast to be followed."
        )
    alone = found.get("alone")
    if alone:
        steps = alone.get("steps_a_period", 1)
        lines.append(
            f"Taken alone, {ALONE_SAID} runs: a step takes {duration_said(alone['p50'])}"
            f" ± {duration_said(alone['p50_spread'])}, p99 {duration_said(alone['p99'])}"
            f" ± {duration_said(alone['p99_spread'])}"
            + (f"; {steps} steps a period." if steps > 1 else ".")
            + (
                f" The machine was busy (load {alone['busy']:.1f} a core): take the times again on an idle"
                " one."
                if alone["busy"] > BUSY
                else ""
            )
        )
    return lines


ALONE_SAID = "nine"
BUSY = 0.7
"""Load a core above which times are not taken alone."""


def _unsure(row: Mapping[str, float], measure: Measure) -> str:
    """A remark where the comparison itself is not much better than what it tells."""
    return f" (± {measure.show(row['unsure'])})" if row["unsure"] > 0.1 * row["error"] else ""


def duration_said(seconds: float) -> str:
    """For example 200 µs."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"


def rate_said(rate: float) -> str:
    """For example 1 kHz."""
    return f"{rate / 1e3:g} kHz" if rate >= 1e3 else f"{rate:g} Hz"
