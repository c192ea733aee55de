"""The part of a report on how the run went: deadlines, pace, rates, jitter, gaps, the clock, warnings."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..bag import Bag
from ..bag.robot import parameter
from ..figures.style import INK
from ..health.examination import Examination
from . import pictures
from .page import Section

MICRO = 1e-6
MOST_LISTED = 12
STEPS = ("step time p50, µs", "step time p99, µs", "step time worst, µs", "tick time p99, µs",
         "tick time worst, µs", "lateness p99, µs", "lateness worst, µs")  # fmt: skip
TOLD = {
    "real-time factor": "real_time_factor", "ticks": "ticks", "overruns": "last_overruns",
    "overruns in a row, worst": "longest_run_of_overruns", "lost time, s": "lost_time",
}  # fmt: skip


def deadline(bag: Bag) -> float | None:
    """Return the time that a tick may take, s, as far as the bag says."""
    for pairs in bag.notes().values():
        rate = parameter(pairs, "rate")
        if isinstance(rate, float) and rate > 0.0:
            return 1.0 / rate
    return None


def health_part(bag: Bag, seen: Examination) -> tuple[Section, dict[str, Any]]:
    """Return the section, and figures for programs."""
    section = Section("Real-time health")
    said = seen.said
    allowed = deadline(bag)
    figures: dict[str, Any] = {"deadline": allowed} | seen.figures()
    told = {word: said.number(key) for key, word in TOLD.items()}
    times = {key.replace(", µs", "").replace(" ", "_"): said.number(key) for key in STEPS}
    figures |= told | {k: None if v is None else MICRO * v for k, v in times.items()}
    if not said.values:
        section.missing("Step time, deadlines and warnings: the bag holds no /diagnostics.")
    else:
        rows = [[key, value] for key in TOLD if (value := said.number(key)) is not None]
        rows += [["deadlines missed while this was recorded", said.missed]]
        if allowed is not None:
            rows += [["deadline, µs", allowed / MICRO]]
        rows += [[key, value] for key in STEPS if (value := said.number(key)) is not None]
        section.table(["at the end of the run", ""], rows)
    if len(said.steps) > 1:
        section.picture(step_times(seen, allowed))
    if len(said.energy) > 1:
        time, _, energy, _ = np.array(said.energy).T
        title = "Kinetic, elastic and gravitational energy"
        section.picture(
            pictures.curves(
                title, time, energy[:, None], ["their sum"], "time of the bag, s", "energy, J", color=INK
            )
        )
    if said.validity:
        section.table(
            ["validity: the largest", "", "at, s of the bag", "warns at", "stops at"],
            [[name, v.value, v.at, "–" if v.warn is None else v.warn, "–" if v.stop is None else v.stop]
             for name, v in said.validity.items()],
        )  # fmt: skip
    rows = []
    for t in seen.timings.values():
        if t.regular and t.interval:
            longest = 0.0 if t.longest is None else t.longest.end - t.longest.begin
            gaps = sum(not gap.still for gap in t.gaps)
            lost = "–" if t.lost is None else t.lost
            latency = "–" if t.latency is None else 1e3 * t.latency
            rate, jitter = 1.0 / t.interval, 1e3 * (t.jitter or 0.0)
            rows.append([t.topic, t.count, rate, jitter, 1e3 * longest, gaps, lost, latency])
    if rows:
        section.table(
            ["topic", "messages", "Hz", "jitter, ms", "longest, ms", "gaps", "lost", "latency, ms"],
            rows,
        )  # fmt: skip
        section.say("Times of receipt; jitter: 99th percentile of how far an interval is from the median.")
    findings = [(f, kind) for kind, some in seen.findings().items() for f in some[:MOST_LISTED]]
    if findings:
        section.table(
            ["when, s of the bag", "kind", "what"],
            [[f"{f.begin:.3f}" if f.end is None else f"{f.begin:.3f} to {f.end:.3f}", kind, f.what]
             for f, kind in findings],
        )  # fmt: skip
        left = sum(max(0, len(some) - MOST_LISTED) for some in seen.findings().values())
        if left:
            section.say(f"And {left} more: flexsim info {bag.path.name} --json lists them all.")
    return section, figures


def step_times(seen: Examination, allowed: float | None) -> str:
    """Draw step and tick times against the deadline."""

    def draw(axes: Any) -> None:
        time = np.array([t for t, _ in seen.said.steps])
        for n, key in enumerate(k for k in STEPS if "lateness" not in k):
            values = np.array([step.get(key, np.nan) for _, step in seen.said.steps])
            if np.isfinite(values).any():
                pictures.plot(axes, time, values, color=pictures.LINES[n % len(pictures.LINES)],
                              label=key.removesuffix(", µs"))  # fmt: skip
        if allowed is not None:
            axes.axhline(allowed / MICRO, color=(0.76, 0.27, 0.24), linestyle="--", label="deadline")
        axes.set(xlabel="time of the bag, s", ylabel="µs", yscale="log")

    return pictures.svg(draw, "Step time against the deadline")
