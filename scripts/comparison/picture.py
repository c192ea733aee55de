"""Two runs in one picture: joints, tips, and what is between them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..figures.style import LINES, styled
from .difference import SECOND
from .saved_run import SavedRun, read

# What is the same is drawn here, since zero has no logarithm.
SMALLEST = 1e-18
MILLIMETRES = 1e3


def draw(paths: tuple[Path, Path], file: Path, names: tuple[str, str], robot: str = "") -> None:
    """Draw two runs into a PNG; raises BagError where they are no robots."""
    first, second = (read(path, robot=robot) for path in paths)
    with styled() as pyplot:
        figure, axes = pyplot.subplots(2, 2, figsize=(14.0, 8.0), layout="constrained", sharex=True)
        title = f"A: {names[0]}   B: {names[1]}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=14, fontweight="bold")
        joints(axes[0, 0], first, second)
        difference(axes[1, 0], first, second, "joint_position", "Joint position: |B − A|, rad or m")
        deflections(axes[0, 1], first, second)
        difference(axes[1, 1], first, second, "node_position", "Nodes: largest distance of A and B, m")
        for below in axes[1]:
            below.set_xlabel("simulated time, s")
        figure.savefig(file, dpi=110)
        pyplot.close(figure)


def joints(axes: Any, first: SavedRun, second: SavedRun) -> None:
    """Draw joint positions."""
    axes.set_title("Joint position, rad or m (A solid, B dashed)")
    for run, style, wide in ((first, "-", 1.2), (second, "--", 2.0)):
        if "joint_position" not in run.values:
            continue
        time = run.time["joint_position"] / SECOND
        for k, column in enumerate(run.values["joint_position"].T):
            name = run.joint_names[k] if k < len(run.joint_names) else f"joint {k + 1}"
            label = name if run is first else None
            axes.plot(time, column, style, color=LINES[k % len(LINES)], linewidth=wide, label=label)
    axes.legend(loc="best", fontsize=8)


def tip(run: SavedRun) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return times, s, and how far the last node is from where the rigid robot has it, m."""
    if "node_position" not in run.values or "rigid_position" not in run.values:
        return None
    off = run.values["node_position"][:, -3:] - run.values["rigid_position"][:, -3:]
    return run.time["node_position"] / SECOND, np.linalg.norm(off, axis=1)


def deflections(axes: Any, first: SavedRun, second: SavedRun) -> None:
    """Draw the tips' deflections."""
    axes.set_title("Tip deflection, mm")
    for run, style, colour, name in ((first, "-", LINES[0], "A"), (second, "--", LINES[1], "B")):
        found = tip(run)
        if found is not None:
            axes.plot(found[0], MILLIMETRES * found[1], style, color=colour, label=name)
    axes.legend(loc="best", fontsize=8)


def difference(axes: Any, first: SavedRun, second: SavedRun, quantity: str, title: str) -> None:
    """Draw the difference over time, on a logarithmic axis."""
    axes.set_title(title)
    if quantity not in first.values or quantity not in second.values:
        return
    common, i, j = np.intersect1d(first.time[quantity], second.time[quantity], return_indices=True)
    a, b = first.values[quantity][i], second.values[quantity][j]
    if a.shape != b.shape:
        axes.text(0.5, 0.5, "not of the same shape", ha="center", transform=axes.transAxes)
        return
    off = np.abs(b - a)
    if quantity == "node_position":
        off = np.linalg.norm((b - a).reshape(len(common), -1, 3), axis=2).max(axis=1, keepdims=True)
    for k, column in enumerate(off.T):
        axes.semilogy(common / SECOND, np.maximum(column, SMALLEST), color=LINES[k % len(LINES)])
    if not off.any():
        axes.text(0.5, 0.5, "the same to the bit", ha="center", transform=axes.transAxes)
