"""How a simulator does: its step time against the deadline, its pace, its energy, its validity."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..bag.diagnostics import OK, Status
from .colour import series
from .window import TIMELINE

STEP = ["step time p50, µs", "step time p99, µs", "step time worst, µs", "tick time worst, µs"]
PLOTS = {
    "step_time": "Step time against the deadline, µs",
    "pace": "Real-time factor, and overruns",
    "energy": "Energy, J",
    "validity": "Validity: shares of the limits, and the like",
}
GROUPS = {
    "pace": ("real-time factor", "real-time factor, last second", "overruns", "lost time, s"),
    "energy": ("kinetic energy, J", "elastic energy, J", "gravitational energy, J"),
}
VALIDITY = re.compile(r"valid", re.IGNORECASE)
LEVELS = {0: "INFO", 1: "WARN", 2: "ERROR", 3: "WARN"}
MICROSECONDS = 1e6


class HealthPlots:
    """Logs diagnostics to a recording.

    Parameters
    ----------
    recording : rerun.RecordingStream
    deadline : float or None, s
        The time that a tick may take.
    """

    def __init__(self, recording: rr.RecordingStream, deadline: float | None) -> None:
        self.recording = recording
        self.deadline = deadline
        self.rows: dict[str, int] = {}
        self._names: dict[str, list[str]] = {}
        self._said: dict[str, tuple[int, str]] = {}

    def log(self, times: Sequence[float], messages: Sequence[Sequence[Status]]) -> None:
        """Log what K messages say, each at its time, s; many at once are much quicker than one by one."""
        rows: dict[str, list[tuple[float, dict[str, float]]]] = {}

        def line(plot: str, time: float, values: dict[str, float]) -> None:
            if values:
                rows.setdefault(plot, []).append((time, values))

        for time, statuses in zip(times, messages, strict=True):
            values: dict[str, float] = {}
            valid: dict[str, float] = {}
            for status in statuses:
                numbers = {k: n for k in status.values if (n := status.number(k)) is not None}
                values |= numbers
                if VALIDITY.search(status.name):
                    valid |= numbers
                else:
                    valid |= {k: n for k, n in numbers.items() if VALIDITY.search(k)}
                self._tell(time, status)
            step = {k: values[k] for k in STEP if k in values}
            if step and self.deadline is not None:
                step["deadline"] = MICROSECONDS * self.deadline
            line("step_time", time, step)
            for plot, keys in GROUPS.items():
                line(plot, time, {k: values[k] for k in keys if k in values})
            line("validity", time, valid)
        for plot, some in rows.items():
            self._lines(plot, some)

    def _tell(self, time: float, status: Status) -> None:
        """Log a status in words where it changes its level, or its words while it is not well."""
        said = (status.level, status.message if status.level != OK else "")
        if self._said.get(status.name, (OK, "")) != said:
            self._said[status.name] = said
            self.recording.set_time(TIMELINE, duration=time)
            words = f"{status.name}: {status.message}"
            self.recording.log("robot/status", rr.TextLog(words, level=LEVELS.get(status.level, "WARN")))

    def _lines(self, plot: str, some: list[tuple[float, dict[str, float]]]) -> None:
        """Log K points of a plot's lines: time, s, and values by name."""
        names = self._names.get(plot)
        if names is None:
            names = self._names[plot] = list(some[0][1])
            colours = [
                (214, 69, 60) if n == "deadline" else c
                for n, c in zip(names, series(len(names)), strict=True)
            ]
            widths = [2.5 if n == "deadline" else 1.5 for n in names]
            self.recording.log(
                f"health/{plot}", rr.SeriesLines(names=names, colors=colours, widths=widths), static=True
            )
        table = np.array([[values.get(name, np.nan) for name in names] for _, values in some])
        self.recording.send_columns(
            f"health/{plot}",
            indexes=[rr.TimeColumn(TIMELINE, duration=[time for time, _ in some])],
            columns=rr.Scalars.columns(scalars=table.ravel()).partition([len(names)] * len(some)),
        )
        self.rows[f"health/{plot}"] = self.rows.get(f"health/{plot}", 0) + len(some)

    def all_views(self) -> list[rrb.TimeSeriesView]:
        """Return all plots, also those that have nothing to show yet."""
        return [rrb.TimeSeriesView(origin=f"health/{p}", name=title) for p, title in PLOTS.items()]

    def views(self) -> list[rrb.TimeSeriesView]:
        """Return the plots that have something to show."""
        return [
            rrb.TimeSeriesView(origin=f"health/{plot}", name=title)
            for plot, title in PLOTS.items()
            if plot in self._names
        ]
