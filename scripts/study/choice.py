"""The frontier of a study, what to use for a budget or a tolerance, and writing that into the scene."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .point import Measure, Outcome

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
            return outcome.median
        if outcome.step is None:
            return outcome.median / self.rate
        steps = math.ceil(1.0 / (self.rate * outcome.step) - 1e-6)
        return steps * outcome.median * outcome.step

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
    """What to use, and why, in one sentence; outcome None where nothing will do."""

    outcome: Outcome | None
    sentence: str


def choose(
    outcomes: Iterable[Outcome],
    measure: Measure,
    cost: Cost,
    budget: float | None,
    tolerance: float | None,
    floor: float,
) -> Choice:
    """The cheapest within a tolerance, or else the best within a budget; with both, within both.

    What counts is a point's lasting error.

    budget : s for a control period (a robot) or a test (a door); tolerance : in SI units
    floor : the smallest error that the study can tell, SI units
    """
    able = [o for o in outcomes if o.ok and not o.effect and math.isfinite(o.error(measure.name))]
    usable = [o for o in able if cost.serves(o)]
    lasting = {o.point: lasting_error(o, able, measure) for o in able}
    asked = _asked(measure, cost, budget, tolerance)
    if not usable:
        return Choice(None, f"For {asked}: no point of the study ran to its end.")
    within = [o for o in usable if budget is None or cost.of(o) <= budget]
    exact = [o for o in within if tolerance is None or lasting[o.point] <= tolerance]
    if exact and tolerance is not None:
        best = min(exact, key=lambda o: (cost.of(o), lasting[o.point]))
    elif exact:
        # Below the floor the study can't tell one from another: there, the cheaper.
        best = min(exact, key=lambda o: (max(lasting[o.point], floor), cost.of(o)))
    elif within:
        best = min(within, key=lambda o: lasting[o.point])
        enough = [o for o in usable if tolerance is None or lasting[o.point] <= tolerance]
        needs = (
            f"that accuracy takes {duration_said(min(cost.of(o) for o in enough))}"
            if enough
            else "no point of the study is that accurate"
        )
        return Choice(
            None,
            f"For {asked} nothing will do: within the time, {use(best, measure, cost)} is the best; {needs}.",
        )
    else:
        best = min(usable, key=cost.of)
        return Choice(None, f"For {asked} nothing will do: the cheapest is {use(best, measure, cost)}.")
    sentence = f"For {asked}, use {use(best, measure, cost)}."
    if lasting[best.point] > LUCK * max(best.error(measure.name), floor):
        sentence += (
            f" Count on {measure.show(lasting[best.point])}: with smaller steps it is that far off, so that"
            " here the errors of step and mesh happen to oppose each other."
        )
    return Choice(best, sentence)


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
        time = f"{duration_said(took)} of each {duration_said(1.0 / cost.rate)} ({took * cost.rate:.1%})"
    return f"{outcome.curve}{step}: {measure.show(outcome.error(measure.name))}, {time}"


def formulations_said(
    own: str | None, others: Mapping[str, Mapping[str, float]], measure: Measure
) -> list[str]:
    """How far the other formulations are, each in a sentence."""
    return [
        f"{name}, without error of step or mesh, is {measure.show(far['distance'])}"
        f" ± {measure.show(far['uncertainty'])} from {own}, this scene's formulation: so far the models"
        " differ, whatever the step. co_moving is the one that holds where links turn elastically."
        for name, far in others.items()
    ]


def duration_said(seconds: float) -> str:
    """For example 200 µs."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"


def rate_said(rate: float) -> str:
    """For example 1 kHz."""
    return f"{rate / 1e3:g} kHz" if rate >= 1e3 else f"{rate:g} Hz"


def write_choice(path: Path, overrides: Mapping[str, Any]) -> None:
    """Put overrides into a scene's file, keeping its comments and its order.

    Raises
    ------
    ValueError
        Where the file has no such place.
    """
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = 4096
    text = path.read_text(encoding="utf-8")
    document = yaml.load(text)
    for dotted, value in overrides.items():
        place: Any = document
        keys = dotted.split(".")
        for key in keys[:-1]:
            place = place[int(key)] if isinstance(place, list) else place.setdefault(key, {})
        place[keys[-1]] = value
    part = path.with_name(path.name + ".part")
    with part.open("w", encoding="utf-8") as file:
        yaml.dump(document, file)
    part.replace(path)
