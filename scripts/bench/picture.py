"""Two controllers side by side: how the tip swings after each run's move, and how the joints follow."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..controller.trajectory import Trajectory
from .score import Recording

MILLIMETRES = 1e3


def draw(runs: dict[str, dict[str, Recording]], wanted: Trajectory, title: str, file: Path) -> None:
    """Draw a row a case and a colour a controller; runs: controller to case to recording."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    cases = list(next(iter(runs.values())))
    figure, axes = pyplot.subplots(
        len(cases),
        2,
        figsize=(13.0, 1.9 * len(cases) + 1.0),
        sharex=True,
        squeeze=False,
        layout="constrained",
    )
    for row, case in zip(axes, cases, strict=True):
        for n, (controller, recordings) in enumerate(runs.items()):
            run = recordings.get(case)
            if run is None or not len(run.time):
                continue
            away = run.tip - run.rigid_tip
            away = away - away[-max(1, len(away) // 10) :].mean(axis=0)
            settled = away[run.time > wanted.time[-1]] if (run.time > wanted.time[-1]).any() else away
            main = np.linalg.svd(settled, full_matrices=False)[2][0]
            main = main * np.sign(main[np.argmax(np.abs(main))])
            row[0].plot(run.time, MILLIMETRES * away @ main, color=f"C{n}", lw=1.0, label=controller)
            reference = np.array([wanted.at(t)[0] for t in run.time])
            error = np.abs(run.position - reference).max(axis=1)
            row[1].semilogy(run.time, np.maximum(error, 1e-6), color=f"C{n}", lw=1.0)
        for axis in row:
            axis.axvspan(wanted.time[0], wanted.time[-1], color="0.93", lw=0)
            axis.grid(color="0.9", lw=0.6)
        row[0].set_ylabel(case)
    axes[0, 0].set_title("deflection of the tip, mm", loc="left")
    axes[0, 1].set_title("largest joint error, rad or m", loc="left")
    axes[0, 0].legend(frameon=False, ncols=2, loc="upper right")
    for axis in axes[-1]:
        axis.set_xlabel("s")
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    figure.savefig(file, dpi=100)
    pyplot.close(figure)
