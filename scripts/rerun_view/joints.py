"""Plots of the joints: position, velocity, effort, one line a joint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from .colour import series

QUANTITIES = {
    "position": "Joint position, rad or m",
    "velocity": "Joint velocity, rad/s or m/s",
    "effort": "Joint effort, N m or N",
}


class JointPlots:
    """Logs joint states to a recording.

    Parameters
    ----------
    recording : rerun.RecordingStream
    names : list of m str
    group : int
        Of several sets of joints that are plotted together, which one.
    """

    def __init__(self, recording: rr.RecordingStream, names: list[str], group: int = 0) -> None:
        self.recording = recording
        self.names = names
        self.places = {q: f"joints/{q}/{group + 1}" if group else f"joints/{q}" for q in QUANTITIES}
        for quantity in QUANTITIES:
            recording.log(
                self.places[quantity],
                rr.SeriesLines(
                    names=names,
                    colors=series(len(names)),
                    widths=[1.5] * len(names),
                    aggregation_policy=rr.components.AggregationPolicy.MinMax,
                ),
                static=True,
            )

    def log(self, indexes: list[rr.TimeColumn], values: Mapping[str, NDArray]) -> None:
        """Log K joint states: `values` holds (K, m) for position, velocity and effort."""
        for quantity in QUANTITIES:
            rows = np.asarray(values[quantity], dtype=np.float64)
            # A driver may leave a quantity out; then there is nothing to plot.
            if rows.ndim != 2 or rows.shape[1] != len(self.names) or not len(rows):
                continue
            self.recording.send_columns(
                self.places[quantity],
                indexes=indexes,
                columns=rr.Scalars.columns(scalars=rows.ravel()).partition([rows.shape[1]] * len(rows)),
            )


def views() -> list[rrb.TimeSeriesView]:
    """Return the plots for a blueprint."""
    return [
        rrb.TimeSeriesView(
            origin=f"joints/{quantity}",
            name=title,
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
        )
        for quantity, title in QUANTITIES.items()
    ]
