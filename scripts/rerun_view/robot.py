"""The robot in 3-D: its deformed shape, the rigid ERLS as a ghost, and its tip's deflection."""

from __future__ import annotations

from inspect import signature
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from . import joints
from .colour import GHOST, NODE, TRACE, along_scale
from .palette import SERIES
from .strain import KINDS, TITLES, Strain
from .tube import ALONE, Skeleton, Tube
from .window import TIMELINE

# Frames of one chunk: small enough that the viewer can load and drop pieces of a long recording.
FRAMES_PER_CHUNK = 200
TRACE_SECONDS = 1.0
GHOST_THICKNESS = 0.6
MILLIMETRES = 1e3


class RobotView:
    """Logs elastic states to a recording.

    Parameters
    ----------
    recording : rerun.RecordingStream
    skeleton : Skeleton
    scale : float
        Shown is rigid + scale * (deformed - rigid).
    full_colour : float, m
        The elastic displacement that gets the strongest colour.
    root : str
        The entity below which it is logged.
    tint : tuple of int, optional
        One colour for all of it, instead of one that shows the displacement.
    strain : Strain, optional
        Shows strains; `full_strain` are those that get the strongest colour.
    """

    def __init__(
        self,
        recording: rr.RecordingStream,
        skeleton: Skeleton,
        *,
        scale: float,
        full_colour: float,
        root: str = "robot",
        tint: tuple[int, int, int] | None = None,
        strain: Strain | None = None,
        full_strain: tuple[float, ...] = (1.0, 1.0, 1.0),
    ) -> None:
        self.recording = recording
        self.root = root
        self.tint = tint
        self.strain = strain
        self.full_strain = full_strain
        self.scale = scale
        self.full_colour = max(full_colour, 1e-9)
        self.tube = Tube(skeleton)
        self.ghost = Tube(skeleton.rigid())
        self.radius = float(skeleton.radius.max(initial=0.0)) or ALONE
        self._tip: NDArray | None = None
        self._status: str | None = None
        recording.log(
            f"{root}/deformed",
            rr.Mesh3D.from_fields(
                triangle_indices=self.tube.triangles,
                albedo_factor=None if tint is None else (*tint, 255),
            ),
            static=True,
        )
        recording.log(
            f"{root}/rigid",
            rr.Mesh3D.from_fields(triangle_indices=self.ghost.triangles, albedo_factor=GHOST),
            static=True,
        )
        recording.log(
            f"{root}/nodes",
            rr.Points3D.from_fields(colors=[NODE], radii=[1.15 * self.radius]),
            static=True,
        )
        recording.log(
            f"{root}/tip",
            rr.LineStrips3D.from_fields(colors=[TRACE], radii=[0.1 * self.radius]),
            static=True,
        )
        if strain is not None:
            for kind in KINDS:
                recording.log(
                    f"{root}/strain/{kind}",
                    rr.LineStrips3D.from_fields(radii=[1.3 * self.radius]),
                    static=True,
                )
        recording.log(
            f"{root}/tip/deflection",
            rr.SeriesLines(
                names=["tip"],
                colors=[SERIES[1]],
                widths=[1.5],
                # Where a pixel holds many samples, the mean of a vibration would hide it.
                aggregation_policy=rr.components.AggregationPolicy.MinMax,
            ),
            static=True,
        )

    def log_shape(self, time: NDArray[np.float64], position: NDArray, rigid_position: NDArray) -> None:
        """Log K shapes.

        Parameters
        ----------
        time : ndarray (K,), s
        position, rigid_position : ndarray (K, 3 N), m
            As in ElasticState.
        """
        for first in range(0, len(time), FRAMES_PER_CHUNK):
            part = slice(first, first + FRAMES_PER_CHUNK)
            self._log_chunk(time[part], position[part], rigid_position[part])

    def _log_chunk(self, time: NDArray, position: NDArray, rigid_position: NDArray) -> None:
        frames = len(time)
        rigid = rigid_position.reshape(frames, -1, 3)
        elastic = position.reshape(frames, -1, 3) - rigid
        shown = rigid + self.scale * elastic
        index = [rr.TimeColumn(TIMELINE, duration=time)]

        vertices, normals = self.tube.vertices(self.tube.centre(shown))
        count = [vertices.shape[1]] * frames
        skin: dict[str, Any] = {
            "vertex_positions": vertices.reshape(-1, 3),
            "vertex_normals": normals.reshape(-1, 3),
        }
        if self.tint is None:
            amount = np.linalg.norm(self.tube.centre(elastic), axis=2) / self.full_colour
            skin["vertex_colors"] = along_scale(self.tube.over_vertices(amount)).ravel()
        self.recording.send_columns(
            f"{self.root}/deformed",
            indexes=index,
            columns=rr.Mesh3D.columns(**skin).partition(count),
        )
        vertices, normals = self.ghost.vertices(self.ghost.centre(rigid), GHOST_THICKNESS)
        count = [vertices.shape[1]] * frames
        self.recording.send_columns(
            f"{self.root}/rigid",
            indexes=index,
            columns=rr.Mesh3D.columns(
                vertex_positions=vertices.reshape(-1, 3), vertex_normals=normals.reshape(-1, 3)
            ).partition(count),
        )
        self.recording.send_columns(
            f"{self.root}/nodes",
            indexes=index,
            columns=rr.Points3D.columns(positions=shown.reshape(-1, 3)).partition([shown.shape[1]] * frames),
        )
        # The trace is made of steps, of which the view shows the last second.
        tip = shown[:, -1]
        before = np.vstack([tip[:1] if self._tip is None else self._tip, tip[:-1]])
        steps = lines(np.stack([before, tip], axis=1))
        self._tip = tip[-1:]
        self.recording.send_columns(
            f"{self.root}/tip", indexes=index, columns=rr.LineStrips3D.columns(strips=steps)
        )

    def log_strain(
        self,
        time: NDArray[np.float64],
        position: NDArray,
        rigid_position: NDArray,
        displacement: NDArray,
    ) -> None:
        """Log how K shapes are stretched, bent and twisted: colours along the links.

        Parameters
        ----------
        time : ndarray (K,), s
        position, rigid_position : ndarray (K, 3 N), m; displacement : ndarray (K, 6 N), m and rad
            As in ElasticState.
        """
        if self.strain is None:
            return
        amounts = self.strain(position, rigid_position, displacement)
        rigid = rigid_position.reshape(len(time), -1, 3)
        shown = rigid + self.scale * (position.reshape(len(time), -1, 3) - rigid)
        strips = lines(shown[:, self.strain.segments].reshape(-1, 2, 3))
        index = [rr.TimeColumn(TIMELINE, duration=time)]
        count = [len(self.strain.segments)] * len(time)
        for k, kind in enumerate(KINDS):
            colours = along_scale(amounts[:, :, k] / max(self.full_strain[k], 1e-15)).ravel()
            self.recording.send_columns(
                f"{self.root}/strain/{kind}",
                indexes=index,
                columns=rr.LineStrips3D.columns(strips=strips, colors=colours).partition(count),
            )

    def log_deflection(self, time: NDArray[np.float64], off: NDArray[np.float64]) -> None:
        """Log how far the tip, the last node, is from where the rigid robot has it, in mm.

        Parameters
        ----------
        time : ndarray (K,), s
        off : ndarray (K, 3), m
        """
        self.recording.send_columns(
            f"{self.root}/tip/deflection",
            indexes=[rr.TimeColumn(TIMELINE, duration=time)],
            columns=rr.Scalars.columns(scalars=np.linalg.norm(off, axis=1) * MILLIMETRES),
        )

    def log_spectrum(self, time: float, frequency: NDArray, amplitude: NDArray) -> None:
        """Log the spectrum of the tip's vibration in the seconds before a time, s; in Hz and mm."""
        self.recording.set_time(TIMELINE, duration=time)
        bars = rr.BarChart(MILLIMETRES * amplitude, color=SERIES[1], **on_axis(frequency))
        self.recording.log(f"{self.root}/tip/spectrum", bars)

    def log_status(self, time: NDArray[np.float64], status: NDArray) -> None:
        """Log the status where it changes."""
        words = [str(word) for word in status]
        before = [self._status, *words]
        changed = [i for i, word in enumerate(words) if word != before[i]]
        if not changed:
            return
        self._status = words[-1]
        levels = ["INFO" if words[i] == "ok" else "WARN" for i in changed]
        self.recording.send_columns(
            f"{self.root}/status",
            indexes=[rr.TimeColumn(TIMELINE, duration=time[changed])],
            columns=rr.TextLog.columns(text=[words[i] for i in changed], level=levels),
        )


def eye(reach: NDArray[np.float64]) -> rrb.EyeControls3D:
    """Look at the robot from where its whole motion is seen.

    Parameters
    ----------
    reach : ndarray (2, 3), m
        The least and the greatest coordinates of its nodes over the recording.
    """
    middle = reach.mean(axis=0)
    extent = reach[1] - reach[0]
    distance = 0.95 * float(np.linalg.norm(extent))
    if extent[2] < 1e-3 * distance:  # a planar robot: face its plane
        direction, up = np.array([0.0, 0.0, 1.0]), (0.0, 1.0, 0.0)
    else:
        direction, up = np.array([0.62, -0.68, 0.38]), (0.0, 0.0, 1.0)
    return rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=middle + distance * direction,
        look_target=middle,
        eye_up=up,
    )


def layout(
    reach: NDArray[np.float64],
    scale: float,
    red: str = "",
    red_strain: tuple[str, ...] | None = None,
    health: list[rrb.TimeSeriesView] | None = None,
) -> rrb.Horizontal:
    """Return the robot's view: 3-D and strains on the left, plots on the right.

    Parameters
    ----------
    reach : ndarray (2, 3), m
    scale : float
        Factor on displacements.
    red : str; red_strain : tuple of str
        What has the strongest colour, of the displacement and of each strain; None: no strains are shown.
    health : list of views
        Plots of how the simulator does.
    """
    spacing = 10.0 ** np.floor(np.log10(max(float(np.ptp(reach, axis=0).max()), 1e-3)))
    trace = rrb.VisibleTimeRanges(
        timeline=TIMELINE,
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRACE_SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(seconds=0.0),
    )
    background = rrb.Background((24, 27, 33))
    space = rrb.Spatial3DView(
        origin="robot",
        contents=["$origin/deformed", "$origin/rigid", "$origin/nodes", "$origin/tip"],
        name=f"Robot, elastic displacement ×{scale:g}{f'; red: {red}' if red else ''}; grey: rigid",
        background=background,
        line_grid=rrb.LineGrid3D(spacing=float(spacing) / 2.0, color=(255, 255, 255, 28)),
        eye_controls=eye(reach),
        overrides={"robot/tip": [trace]},
    )
    left: list[rrb.Container | rrb.View] = [space]
    shares = [5.5]
    if red_strain is not None:
        views = [
            rrb.Spatial3DView(
                origin="robot",
                contents=[f"$origin/strain/{kind}"],
                name=f"{TITLES[kind]}; red: {amount}",
                background=background,
                line_grid=rrb.LineGrid3D(visible=False),
                eye_controls=eye(reach),
            )
            for kind, amount in zip(KINDS, red_strain, strict=True)
        ]
        left.append(rrb.Horizontal(*views))
        shares.append(2.5)
    left.append(rrb.TextLogView(origin="robot/status", name="Status"))
    shares.append(2.0)
    deflection = rrb.TimeSeriesView(origin="robot/tip/deflection", name="Tip deflection, mm")
    bars = rrb.BarChartView(
        origin="robot/tip/spectrum", name="Spectrum of the tip's last 4 s: amplitude, mm, over Hz"
    )
    position, velocity, effort = joints.views()
    motion = rrb.Vertical(deflection, position, bars, name="Motion")
    more = rrb.Vertical(position, velocity, effort, name="Joints")
    plots: list[rrb.Container | rrb.View] = [motion, more]
    if health:
        plots.append(rrb.Vertical(*health, name="Health"))
    return rrb.Horizontal(
        rrb.Vertical(*left, row_shares=shares), rrb.Tabs(*plots, active_tab=0), column_shares=[3, 2]
    )


def lines(strips: NDArray) -> pa.Array:
    """Return lines (K, P, 3) as rerun keeps them: made at once, not one by one."""
    many, points, _ = strips.shape
    numbers = pa.array(np.ascontiguousarray(strips, dtype=np.float32).ravel())
    kind = rr.components.LineStrip3DBatch._ARROW_DATATYPE
    vectors = pa.FixedSizeListArray.from_arrays(numbers, type=kind.value_type)
    offsets = pa.array(np.arange(many + 1, dtype=np.int32) * points)
    return pa.ListArray.from_arrays(offsets, vectors, type=kind)


def on_axis(frequency: NDArray) -> dict[str, Any]:
    """Return what puts bars at their frequencies; an older rerun counts them."""
    if "abscissa" in signature(rr.BarChart.__init__).parameters:
        return {"abscissa": frequency}
    return {}
