"""The picture of a robot's modes: each shape in space, and how frequencies change over the workspace."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsim_node import Modes

from ..rerun_view.colour import SERIES

INK, GRID, GHOST = "#22262e", "#d9dce1", "#b4bac4"
COLOURS = [tuple(c / 255 for c in colour) for colour in SERIES]
BLUE, ORANGE = COLOURS[5], COLOURS[6]
COLUMNS = 3
MOST = 6  # shapes in one picture
SWING = 0.12  # of the robot's size: how far the largest displacement is drawn
POINTS = 9  # of an element's curve
STYLE = {
    "font.size": 9, "axes.edgecolor": INK, "axes.labelcolor": INK, "text.color": INK,
    "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": GRID, "grid.linewidth": 0.6, "axes.titlelocation": "left",
    "axes.titlesize": 10, "axes.titleweight": "bold", "legend.frameon": False,
}  # fmt: skip
Grid = tuple[tuple[str, ...], NDArray[np.float64], NDArray[np.float64]]


def draw(title: str, modes: Modes, grid: Grid | None, file: Path) -> None:
    """Draw shapes, and with `grid` (joints (d,), positions (K, d), Hz (K, n)) curves, into a picture."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    shown = min(MOST, len(modes.frequency))
    rows = -(-shown // COLUMNS)
    with pyplot.rc_context(STYLE):
        above = 1 if grid is not None else 0
        heights = [1.1] * above + [1.0] * rows
        figure = pyplot.figure(figsize=(13.0, 4.0 * sum(heights) + 0.6), layout="constrained")
        cells = figure.add_gridspec(rows + above, COLUMNS, height_ratios=heights)
        if grid is not None:
            workspace(figure, cells[0, :], grid, shown)
        for mode in range(shown):
            cell = cells[above + mode // COLUMNS, mode % COLUMNS]
            shape(figure.add_subplot(cell, projection="3d"), modes, mode)
        figure.suptitle(title, x=0.01, ha="left", fontsize=13, fontweight="bold")
        figure.savefig(file, dpi=110)
        pyplot.close(figure)


def workspace(figure: Any, cell: Any, grid: Grid, shown: int) -> None:
    """Frequencies along one joint; over two joints a map of each of the lowest three."""
    names, places, found = grid
    if len(names) == 1:
        axes = figure.add_subplot(cell)
        for mode in range(min(shown, found.shape[1])):
            axes.plot(
                places[:, 0], found[:, mode], color=COLOURS[mode % len(COLOURS)], label=f"mode {mode + 1}"
            )
        axes.set(xlabel=f"{names[0]}, rad or m", ylabel="Hz", title="Natural frequencies over the workspace")
        axes.set_ylim(bottom=0.0)
        axes.legend(ncols=shown, loc="upper right", bbox_to_anchor=(1.0, 1.14))
        return
    inner = cell.subgridspec(1, COLUMNS)
    for mode in range(min(COLUMNS, found.shape[1])):
        axes = figure.add_subplot(inner[mode])
        drawn = axes.tricontourf(places[:, 0], places[:, 1], found[:, mode], levels=12)
        figure.colorbar(drawn, ax=axes, label="Hz")
        axes.set(xlabel=f"{names[0]}, rad or m", ylabel=f"{names[1]}, rad or m", title=f"Mode {mode + 1}")


def shape(axes: Any, modes: Modes, mode: int) -> None:
    """One mode at both ends of its swing, over the robot at rest."""
    rest = modes.node_position
    size = float(np.max(np.ptp(rest, axis=0))) or 1.0
    largest = float(np.max(np.abs(modes.shape[mode]))) or 1.0
    scale = SWING * size / largest
    everything = []
    for sign, colour, width in ((0.0, GHOST, 1.4), (1.0, BLUE, 2.4), (-1.0, ORANGE, 1.0)):
        for link in range(len(modes.link_names)):
            curve = bent(modes, mode, link, sign * scale)
            axes.plot(*curve.T, color=colour, linewidth=width, solid_capstyle="round")
            everything.append(curve)
    points = np.concatenate(everything)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.5 * np.maximum(np.ptp(points, axis=0), 0.3 * size)
    axes.set(**{f"{k}lim": (m - h, m + h) for k, m, h in zip("xyz", middle, half, strict=True)})
    axes.set_aspect("equal")
    axes.set_box_aspect(axes.get_box_aspect(), zoom=0.85)
    words = modes.name(mode).replace(", ", ",\n")
    axes.set_title(f"{modes.frequency[mode]:.4g} Hz: {words}", fontsize=8.5, y=0.98, va="top")
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y"), (axes.zaxis, "z")):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_major_locator(_few_ticks())
        axis.set_label_text(f"{name}, m")


def bent(modes: Modes, mode: int, link: int, scale: float) -> NDArray[np.float64]:
    """(P, 3) a link's centreline, Hermite cubics between its nodes."""
    nodes = np.flatnonzero(modes.node_link == link)
    at = modes.node_position[nodes] + scale * modes.shape[mode, nodes]
    normal = modes.node_normal[nodes] + scale * modes.slope[mode, nodes]
    length = np.linalg.norm(np.diff(modes.node_position[nodes], axis=0), axis=1)
    xi = np.linspace(0.0, 1.0, POINTS)[:, None]
    curves = [at[:1]]
    for k, step in enumerate(length):
        curves.append(
            (1 - 3 * xi**2 + 2 * xi**3) * at[k]
            + (3 * xi**2 - 2 * xi**3) * at[k + 1]
            + step * (xi - 2 * xi**2 + xi**3) * normal[k]
            + step * (xi**3 - xi**2) * normal[k + 1]
        )
    return np.concatenate(curves)


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)
