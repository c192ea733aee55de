"""The work-precision diagram: error against time, both logarithmic, one curve a method."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from .choice import Cost, duration_said, rate_said
from .point import Measure, Outcome

MARKERS = "osD^v<>Ph*X"


def draw(
    path: Path,
    title: str,
    outcomes: list[Outcome],
    best: list[Outcome],
    measure: Measure,
    floor: float,
    cost: Cost,
    budget: float | None,
) -> None:
    """Write a PNG.

    floor : errors below it are drawn at it, because the reference tells no more
    budget : s for a control period, drawn as the region that it allows
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(10.5, 6.5), constrained_layout=True)
    curves: dict[str, list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        if outcome.ok and not outcome.effect and np.isfinite(outcome.error(measure.name)):
            curves[outcome.curve].append(outcome)
    colours = plt.get_cmap("tab20")
    for number, (name, points) in enumerate(curves.items()):
        points.sort(key=lambda o: o.size)
        x = np.array([o.median for o in points])
        spread = np.array([o.spread for o in points]) * x
        y = np.array([max(o.error(measure.name), floor) for o in points]) * measure.scale
        style: dict[str, Any] = {
            "color": colours(number % 20),
            "marker": MARKERS[number // 20 % len(MARKERS)] if len(points) > 1 else "x",
            "markersize": 4.5,
            "linewidth": 1.2,
        }
        axes.errorbar(x, y, xerr=spread, label=name, elinewidth=0.6, **style)
    ideal = np.array([[o.median, max(o.error(measure.name), floor)] for o in best])
    if len(ideal):
        axes.step(ideal[:, 0], ideal[:, 1] * measure.scale, where="post", color="0.3", lw=3, alpha=0.25,
                  label="frontier", zorder=0)  # fmt: skip
    axes.axhline(floor * measure.scale, color="0.5", linestyle=":", linewidth=1)
    axes.annotate("ten times the reference's own error", (0.01, floor * measure.scale),
                  xycoords=("axes fraction", "data"), fontsize=7, color="0.4", va="bottom")  # fmt: skip
    if cost.rate is not None:
        axes.axvline(1.0, color="crimson", linewidth=1.2)
        axes.annotate("real time", (1.0, 0.99), xycoords=("data", "axes fraction"), rotation=90,
                      va="top", ha="right", fontsize=8, color="crimson")  # fmt: skip
        if budget is not None:
            load = budget * cost.rate
            axes.axvspan(1e-12, load, color="seagreen", alpha=0.08)
            axes.annotate(
                f"{duration_said(budget)} at {rate_said(cost.rate)}", (load, 0.99),
                xycoords=("data", "axes fraction"), rotation=90, va="top", ha="right", fontsize=8,
                color="seagreen")  # fmt: skip
    elif budget is not None:
        axes.axvspan(1e-12, budget, color="seagreen", alpha=0.08)
    everything = [o.median for points in curves.values() for o in points]
    axes.set_xscale("log")
    axes.set_yscale("log")
    if everything:
        axes.set_xlim(min(everything) / 1.6, max([*everything, 1.3 if cost.rate else 0.0]) * 1.6)
    axes.set_xlabel("time for a simulated second, s" if cost.rate else "processor time for the test, s")
    axes.set_ylabel(f"largest error: {measure.label}, {measure.unit}")
    axes.set_title(title)
    axes.grid(True, which="both", alpha=0.2)
    axes.legend(fontsize=6.5, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)
