"""The door: its leaf in 3-D from both sides, its thermocouples against their limits, infrared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from .colour import GHOST, SERIES, along_scale, series
from .leaf import Skin, outline, skins
from .window import window

TIMELINE = "time"
FRAMES_PER_CHUNK = 50
MILLIMETRES = 1e3
PERCENT = 100.0
REACTIONS = "door/reactions"
PLAYBACK_SPEED = 60.0
"""Simulated seconds a second: a fire takes its time."""
LIVE_WINDOW = 1800.0
"""s of simulated time that plots show while the door burns."""
LIMIT = (214, 69, 60)
BACKGROUND = (24, 27, 33)
MEAN, MAXIMUM = "mean temperature rise", "maximum temperature rise"
# The thermocouples whose mean is judged; thermal_node always has them.
MEAN_OF = "ftp_"
STAMP = ["header.stamp.sec", "header.stamp.nanosec"]


@dataclass(frozen=True)
class Range:
    """Temperatures that get the calmest and the strongest colour, °C."""

    low: float
    high: float

    def fraction(self, temperature: NDArray) -> NDArray:
        """Return 0 at the calmest, 1 at the strongest."""
        return (temperature - self.low) / max(self.high - self.low, 1e-6)

    def __str__(self) -> str:
        return f"{self.low:.0f} (blue) to {self.high:.0f} °C (red)"


FIRE_RANGE = Range(20.0, 1000.0)
UNEXPOSED_RANGE = Range(20.0, 250.0)


def stamps(columns: Mapping[str, NDArray]) -> NDArray[np.float64]:
    """Return the times of messages, s, by their stamps: a door may burn faster than the clock."""
    return np.float64(columns[STAMP[0]]) + 1e-9 * columns[STAMP[1]]


class DoorView:
    """Logs what thermal_node publishes to a recording.

    Parameters
    ----------
    recording : rerun.RecordingStream
    nodes (N, 3), m; hexahedra (C, 8) : as in LeafMesh
    scale : float
        Factor on displacements.
    fire, unexposed : Range
        Colours of the two sides.
    """

    def __init__(
        self,
        recording: rr.RecordingStream,
        nodes: NDArray[np.float64],
        hexahedra: NDArray[np.integer],
        *,
        scale: float,
        fire: Range = FIRE_RANGE,
        unexposed: Range = UNEXPOSED_RANGE,
    ) -> None:
        self.recording = recording
        self.nodes = nodes
        self.scale = scale
        self.ranges = {"fire_side": fire, "unexposed_side": unexposed}
        self.skins: dict[str, Skin] = dict(
            zip(("fire_side", "unexposed_side"), skins(hexahedra), strict=True)
        )
        self._said: tuple[str, ...] = ()
        self._named: set[str] = set()
        self._span = (np.inf, -np.inf)
        for name, skin in self.skins.items():
            self._static(
                f"door/{name}",
                rr.Mesh3D.from_fields(triangle_indices=skin.triangles, vertex_normals=skin.normals),
            )
        self._static(
            "door/cold",
            rr.LineStrips3D(list(outline(nodes)), colors=[GHOST], radii=[0.002]),
        )

    def log_leaf(self, time: NDArray[np.float64], temperature: NDArray, displacement: NDArray) -> None:
        """Log K leaves: time (K,), s; temperature (K, N), °C; displacement (K, N, 3), m."""
        for first in range(0, len(time), FRAMES_PER_CHUNK):
            part = slice(first, first + FRAMES_PER_CHUNK)
            for name, skin in self.skins.items():
                count = [len(skin.node)] * len(time[part])
                shown = self.nodes[skin.node] + self.scale * displacement[part][:, skin.node]
                colour = along_scale(self.ranges[name].fraction(temperature[part][:, skin.node]))
                self._columns(
                    f"door/{name}",
                    time[part],
                    rr.Mesh3D.columns(
                        vertex_positions=shown.reshape(-1, 3).astype(np.float32),
                        vertex_colors=colour.ravel(),
                    ).partition(count),
                )

    def log_image(self, time: NDArray[np.float64], images: NDArray[np.float32]) -> None:
        """Log infrared images (K, height, width), °C."""
        _, height, width = images.shape
        span = self.ranges["unexposed_side"]
        pixels = rr.components.ImageFormat(
            width=width, height=height, channel_datatype=rr.ChannelDatatype.F32
        )
        if "door/infrared" not in self._named:
            self._named.add("door/infrared")
            self._static(
                "door/infrared",
                rr.DepthImage.from_fields(
                    format=pixels, colormap="inferno", depth_range=[span.low, span.high]
                ),
            )
        buffers = [image.astype("<f4").tobytes() for image in images]
        self._columns("door/infrared", time, rr.DepthImage.columns(buffer=buffers))

    def log_thermocouples(
        self,
        time: NDArray[np.float64],
        names: list[str],
        place: NDArray[np.float64],
        temperature: NDArray[np.float64],
    ) -> None:
        """Log readings (K, P), °C, of thermocouples at `place` (P, 3), m.

        Where two sit in one place, the latter is shown, which bears the scene's own name.
        """
        outside = place[:, 2] >= place[:, 2].max() - 1e-9
        latest = {tuple(np.round(p, 6)): i for i, p in enumerate(place)}
        kept = np.array(sorted(latest.values()))
        for entity, chosen in (
            ("door/thermocouples/unexposed", kept[outside[kept]]),
            ("door/thermocouples/inside", kept[~outside[kept]]),
        ):
            if len(chosen):
                self._lines(entity, [names[i] for i in chosen], time, temperature[:, chosen])

    def log_limits(
        self,
        time: NDArray[np.float64],
        names: list[str],
        limit: NDArray[np.float64],
        cold: float,
    ) -> None:
        """Log the limits of the temperature rises as lines in °C above the cold door."""
        for word, criterion in (("mean", MEAN), ("maximum", MAXIMUM)):
            if criterion in names:
                level = cold + limit[:, names.index(criterion)]
                self._lines(
                    f"door/thermocouples/limit_{word}",
                    [f"limit of the {word}"],
                    time,
                    level[:, None],
                    colours=[LIMIT if word == "maximum" else SERIES[1]],
                    width=3.0,
                )

    def log_furnace(self, time: NDArray[np.float64], temperature: NDArray[np.float64]) -> None:
        """Log the furnace, °C."""
        self._lines("door/furnace", ["furnace"], time, temperature[:, None], colours=[LIMIT])

    def log_criteria(
        self,
        time: NDArray[np.float64],
        names: list[str],
        value: NDArray[np.float64],
        limit: NDArray[np.float64],
        verdict: NDArray,
    ) -> None:
        """Log each criterion (K, C) as a share of its limit, and the verdict where it changes."""
        self._lines("door/criteria", names, time, value / limit)
        self._lines(
            "door/criteria/limit", ["limit"], time, np.ones((len(time), 1)), colours=[LIMIT],
            width=3.0,
        )  # fmt: skip
        for t, words in zip(time, verdict, strict=True):
            # Kelvins and minutes change all the time; only the class and a failure are news.
            head, *rest = str(words).split(";")
            news = head if "exceeded" in head else head.partition(":")[0]
            key = (news, *(part for part in rest if "rise" not in part and " of " not in part))
            if key != self._said:
                self._said = key
                level = "WARN" if "exceeded" in str(words) else "INFO"
                self._columns(
                    "door/verdict",
                    np.array([t]),
                    rr.TextLog.columns(text=[str(words)], level=[level]),
                )

    def log_deflection(
        self,
        time: NDArray[np.float64],
        bow: NDArray[np.float64],
        edge_names: list[str],
        edge_gap: NDArray[np.float64],
    ) -> None:
        """Log bow (K,) and gaps at the edges (K, E), m, in mm."""
        values = MILLIMETRES * np.column_stack([bow, edge_gap])
        self._lines("door/deflection", ["bow", *(f"gap, {name}" for name in edge_names)], time, values)

    def log_reactions(self, time: NDArray[np.float64], names: list[str], degree: NDArray[np.float64]) -> None:
        """Log how far reactions have gone (K, R), 0 to 1, in per cent."""
        self._lines(REACTIONS, names, time, PERCENT * degree)

    def layout(self, *, live: bool = False) -> rrb.Horizontal:
        """Return the view: both sides, infrared, plots; of reactions where some were logged."""
        reacts = REACTIONS in self._named
        fire, unexposed = self.ranges["fire_side"], self.ranges["unexposed_side"]
        bent = f"displacement ×{self.scale:g}"
        first, last = self._span
        if live or last <= first:
            begin = rrb.TimeRangeBoundary.cursor_relative(seconds=-LIVE_WINDOW)
            end = rrb.TimeRangeBoundary.cursor_relative(seconds=0.0)
        else:
            begin = rrb.TimeRangeBoundary.absolute(seconds=first)
            end = rrb.TimeRangeBoundary.absolute(seconds=last)
        shown = rrb.TimeAxis(view_range=rrb.TimeRange(begin, end))
        return rrb.Horizontal(
            rrb.Vertical(
                rrb.Horizontal(
                    self._side("fire_side", f"Fire side, {fire}; {bent}"),
                    self._side("unexposed_side", f"Unexposed side, {unexposed}; {bent}"),
                    rrb.Spatial2DView(
                        origin="door/infrared",
                        name=f"Infrared, {unexposed.low:.0f} to {unexposed.high:.0f} °C",
                        background=rrb.Background(BACKGROUND),
                    ),
                    column_shares=[3, 3, 2],
                ),
                rrb.TextLogView(origin="door/verdict", name="Verdict"),
                row_shares=[6, 1],
            ),
            rrb.Vertical(
                _plot("Unexposed thermocouples and limits, °C", "door/thermocouples", shown,
                      ["$origin/unexposed", "$origin/limit_mean", "$origin/limit_maximum"]),
                _plot("Furnace and inside the leaf, °C", "door", shown,
                      ["$origin/furnace", "$origin/thermocouples/inside"]),
                _plot("Criteria, share of their limits", "door/criteria", shown),
                _plot("Deflection, mm", "door/deflection", shown),
                *([_plot("Reactions, % gone", REACTIONS, shown)] if reacts else []),
                row_shares=[3, 2, 2, 2, *([2] if reacts else [])],
            ),
            column_shares=[3, 2],
        )  # fmt: skip

    def blueprint(self, *, live: bool = False) -> rrb.Blueprint:
        """Return the blueprint of a door alone."""
        return window(self.layout(live=live), live=live, speed=PLAYBACK_SPEED)

    def _side(self, name: str, title: str) -> rrb.Spatial3DView:
        low, high = self.nodes.min(axis=0), self.nodes.max(axis=0)
        middle = 0.5 * (low + high)
        distance = 1.35 * float(np.linalg.norm(high - low))
        towards = -1.0 if name == "fire_side" else 1.0
        direction = np.array([0.45 * towards, 0.22, 0.87 * towards])
        return rrb.Spatial3DView(
            origin="door",
            contents=[f"$origin/{name}", "$origin/cold"],
            name=title,
            background=rrb.Background(BACKGROUND),
            line_grid=rrb.LineGrid3D(visible=False),
            eye_controls=rrb.EyeControls3D(
                kind=rrb.Eye3DKind.Orbital,
                position=middle + distance * direction,
                look_target=middle,
                eye_up=(0.0, 1.0, 0.0),
            ),
        )

    def _lines(
        self,
        entity: str,
        names: list[str],
        time: NDArray[np.float64],
        values: NDArray[np.float64],
        colours: list[tuple[int, int, int]] | None = None,
        width: float = 1.5,
    ) -> None:
        if entity not in self._named:
            self._named.add(entity)
            self._static(
                entity,
                rr.SeriesLines(
                    names=names,
                    colors=colours or series(len(names)),
                    widths=[width] * len(names),
                ),
            )
        self._columns(
            entity,
            time,
            rr.Scalars.columns(scalars=values.ravel()).partition([values.shape[1]] * len(time)),
        )

    def _static(self, entity: str, what: rr.AsComponents) -> None:
        self.recording.log(entity, what, static=True)

    def _columns(self, entity: str, time: NDArray[np.float64], columns: Any) -> None:
        if len(time):
            first, last = self._span
            self._span = (min(first, float(time.min())), max(last, float(time.max())))
        self.recording.send_columns(entity, indexes=[rr.TimeColumn(TIMELINE, duration=time)], columns=columns)


def _plot(
    title: str, origin: str, shown: rrb.TimeAxis, contents: list[str] | None = None
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        name=title,
        contents=contents or ["$origin/**"],
        axis_x=shown,
        # Of many thermocouples some stay low; other curves rise soon and leave the corner below.
        plot_legend=rrb.PlotLegend(
            rrb.Corner2D.LeftTop if "limit" in title and contents else rrb.Corner2D.RightBottom
        ),
    )


def cold_temperature(
    names: list[str], readings: NDArray[np.float64], criteria: list[str], value: NDArray[np.float64]
) -> float | None:
    """Return what rises are counted from, °C, from readings and criteria of one instant."""
    judged = [i for i, name in enumerate(names) if name.startswith(MEAN_OF)]
    if not judged or MEAN not in criteria:
        return None
    return float(readings[judged].mean() - value[criteria.index(MEAN)])


def between(
    time: NDArray[np.float64], known: NDArray[np.float64], displacement: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return displacements (K, N, 3) at `time`, straight between known ones (D, N, 3).

    A door begins unbent; after the last shape it stays as it is.
    """
    known = np.concatenate([[min(0.0, known[0] - 1e-9)], known])
    after = np.clip(np.searchsorted(known, time), 1, len(known) - 1)
    share = np.clip((time - known[after - 1]) / (known[after] - known[after - 1]), 0.0, 1.0)
    shapes = np.concatenate([np.zeros_like(displacement[:1]), displacement])
    s = share[:, None, None]
    return np.asarray((1.0 - s) * shapes[after - 1] + s * shapes[after])
