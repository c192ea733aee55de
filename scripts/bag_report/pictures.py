"""Plots as inline SVG: no file beside the page, and nothing that a browser would fetch."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..figures.style import LINES, styled

Array = NDArray[np.float64]
SIZE = (9.0, 2.9)
# A line is drawn with so many points: what lies between them is kept by its least and largest.
POINTS = 1200
HASH_SALT = "flexsim"
DASHES = ("-", "--", ":", "-.")


def thin(time: Array, values: Array) -> tuple[Array, Array]:
    """Return a line (K,) with at most 2 POINTS points that looks the same: of each piece its extremes."""
    if len(time) <= 2 * POINTS:
        return time, values
    first = np.linspace(0, len(time), POINTS + 1).astype(int)[:-1]
    piece = np.repeat(np.arange(POINTS), np.diff(first, append=len(time)))
    keep = [[0, len(time) - 1], first[np.logical_and.reduceat(~np.isfinite(values), first)]]
    # Where nothing is finite a gap is left; elsewhere it counts for nothing.
    for extreme, worst in ((np.minimum, np.inf), (np.maximum, -np.inf)):
        known = np.where(np.isfinite(values), values, worst)
        at = np.flatnonzero((known == extreme.reduceat(known, first)[piece]) & np.isfinite(values))
        keep.append(at[np.diff(piece[at], prepend=-1) > 0])
    some = np.unique(np.concatenate(keep))
    return time[some], values[some]


def plot(axes: Any, time: Array, values: Array, **style: Any) -> None:
    """Draw a line, thinned."""
    axes.plot(*thin(time, values), **style)


def lines(axes: Any, time: Array, values: Array, names: Sequence[str], **style: Any) -> None:
    """Draw the columns (K, d), each in its colour; where these are used up, dashed."""
    for k, name in enumerate(names):
        own = {
            "label": name,
            "color": LINES[k % len(LINES)],
            "linestyle": DASHES[k // len(LINES) % len(DASHES)],
        }
        plot(axes, time, values[:, k], **{**own, **style})


def svg(draw: Callable[[Any], None], title: str, size: tuple[float, float] = SIZE, columns: int = 1) -> str:
    """Return a picture that `draw` draws on axes, or on several (columns,), as an <svg> element."""
    with styled() as pyplot:
        pyplot.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": HASH_SALT + title})
        figure, axes = pyplot.subplots(
            1, columns, sharey=True, squeeze=False, figsize=size, layout="constrained"
        )
        draw(axes[0] if columns > 1 else axes[0][0])
        labels = axes[0][-1].get_legend_handles_labels()[1]
        if labels:
            wide = 1 if len(labels) <= 10 else 2
            axes[0][-1].legend(fontsize=8, ncols=wide, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        out = io.StringIO()
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        figure.savefig(out, format="svg", metadata=nothing)
        pyplot.close(figure)
    return inline(out.getvalue(), title)


def curves(
    title: str, time: Array, values: Array, names: Sequence[str], xlabel: str, ylabel: str, **style: Any
) -> str:
    """Return a picture of lines (K, d) over time."""

    def draw(axes: Any) -> None:
        lines(axes, time, values, names, **style)
        axes.set(xlabel=xlabel, ylabel=ylabel)

    return svg(draw, title)


def inline(text: str, title: str) -> str:
    """Return an SVG file as an element of a page: without namespaces, which look like addresses."""
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", text).replace("xlink:href", "href")
    label = html.escape(title, quote=True)
    return re.sub(r"<svg ", f'<svg role="img" aria-label="{label}" ', text, count=1)
