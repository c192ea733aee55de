"""Colours, lines and letters of pictures that matplotlib draws."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..rerun_view.palette import SERIES

INK, GRID, GHOST = "#22262e", "#d9dce1", "#b4bac4"
COLOURS = [tuple(c / 255 for c in colour) for colour in SERIES]
BLUE, ORANGE = COLOURS[5], COLOURS[6]
STYLE = {
    "font.size": 10, "axes.edgecolor": INK, "axes.labelcolor": INK, "text.color": INK,
    "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "grid.color": GRID, "grid.linewidth": 0.6,
    "axes.titlelocation": "left", "axes.titlesize": 11, "axes.titleweight": "bold",
    "legend.frameon": False, "lines.linewidth": 1.2, "axes.axisbelow": True,
}  # fmt: skip


@contextmanager
def styled() -> Iterator[Any]:
    """Give pyplot, without a window and with the project's look."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with pyplot.rc_context(STYLE):
        yield pyplot


def on_white(colour: tuple[float, ...]) -> tuple[float, ...]:
    """Return a colour that is told from a white ground: yellow is darkened."""
    return tuple(0.75 * c for c in colour) if sum(colour) > 2.0 else colour


LINES = [on_white(c) for c in (COLOURS[5], COLOURS[6], COLOURS[2], COLOURS[3], COLOURS[1], COLOURS[0])]
