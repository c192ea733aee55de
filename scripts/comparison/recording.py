"""Two robots in one rerun recording: side by side in time, one upon the other in space."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from ..bag import BagError
from ..rerun_view import robot, viewer
from ..rerun_view.palette import SERIES
from ..rerun_view.robot import RobotView
from ..rerun_view.robot_bag import LAYOUT, skeleton, topics
from ..rerun_view.tube import Skeleton
from ..rerun_view.window import window
from .difference import SECOND
from .picture import tip
from .saved_run import SavedRun, read

APPLICATION = "flexsim"
MILLIMETRES = 1e3
FRAMES = 3000
TINTS = (SERIES[0], SERIES[1])


def record(
    paths: tuple[Path, Path], file: Path, names: tuple[str, str], scale: float, robot: str = ""
) -> dict[str, int]:
    """Write a recording of both runs; returns the rows of each entity.

    Raises
    ------
    BagError
        Neither of them holds the layout of its robot, or one holds no elastic states.
    """
    runs = [read(path, robot=robot) for path in paths]
    frame = next((s for s in map(layout_of, runs) if s is not None), None)
    if frame is None:
        raise BagError(
            "neither run holds the layout of its robot; one of them is to be a bag with elastic_layout"
        )
    for path, run in zip(paths, runs, strict=True):
        if "rigid_position" not in run.values:
            raise BagError(f"{path} holds no elastic states to show")
    recording = rr.RecordingStream(APPLICATION)
    target = viewer.attach(recording, save=str(file), serve=False)
    try:
        rows = log(recording, runs, frame, names, scale)
    except ValueError:
        target.discard()
        raise
    recording.flush()
    return rows


def layout_of(run: SavedRun) -> Skeleton | None:
    """Return the skeleton of a run's robot, or None where it is not known."""
    if run.bag is None:
        return None
    topic = topics(run.bag).get(LAYOUT)
    return None if topic is None else skeleton(run.bag, topic)


def log(
    recording: rr.RecordingStream, runs: list[SavedRun], frame: Skeleton, names: tuple[str, str], scale: float
) -> dict[str, int]:
    """Log both robots, their joints and their tips, and what is between them."""
    rows: dict[str, int] = {}
    recording.send_recording_name(f"{names[0]} and {names[1]}")
    for letter, run, tint in zip("ab", runs, TINTS, strict=True):
        view = RobotView(recording, frame, scale=scale, full_colour=1.0, root=f"{letter}/robot", tint=tint)
        time = run.time["node_position"] / SECOND
        thin = slice(None, None, 1 + len(time) // FRAMES)
        view.log_shape(time[thin], run.values["node_position"][thin], run.values["rigid_position"][thin])
        rows[f"{letter}/robot/deformed"] = len(time[thin])
        found = tip(run)
        if found is not None:
            rows |= series(
                recording, f"tip/{letter}", found[0], MILLIMETRES * found[1], [letter.upper()], [tint]
            )
        if "joint_position" in run.values:
            time, values = run.time["joint_position"] / SECOND, run.values["joint_position"]
            labels = [f"{letter.upper()} {n}" for n in run.joint_names]
            rows |= series(recording, f"joints/{letter}", time, values, labels, [tint] * len(labels))
    rows |= between(recording, runs)
    nodes = runs[0].values["rigid_position"].reshape(-1, 3)
    recording.send_blueprint(blueprint(np.array([nodes.min(axis=0), nodes.max(axis=0)]), names, scale))
    return rows


def between(recording: rr.RecordingStream, runs: list[SavedRun]) -> dict[str, int]:
    """Log the distance of the two robots' tips, mm."""
    first, second = (run.time["node_position"] for run in runs)
    common, i, j = np.intersect1d(first, second, return_indices=True)
    a, b = (run.values["node_position"][k, -3:] for run, k in zip(runs, (i, j), strict=True))
    distance = MILLIMETRES * np.linalg.norm(b - a, axis=1)
    return series(recording, "between", common / SECOND, distance, ["distance of the tips"], [SERIES[3]])


def series(
    recording: rr.RecordingStream,
    entity: str,
    time: NDArray[np.float64],
    values: NDArray[np.float64],
    names: list[str],
    colours: list[tuple[int, int, int]],
) -> dict[str, int]:
    """Log lines of a plot: values (K,) or (K, n)."""
    recording.log(entity, rr.SeriesLines(names=names, colors=colours, widths=[1.5] * len(names)), static=True)
    many = values.reshape(len(time), -1)
    recording.send_columns(
        entity,
        indexes=[rr.TimeColumn(robot.TIMELINE, duration=time)],
        columns=rr.Scalars.columns(scalars=many.ravel()).partition([many.shape[1]] * len(time)),
    )
    return {entity: len(time)}


def blueprint(reach: NDArray[np.float64], names: tuple[str, str], scale: float) -> rrb.Blueprint:
    """Return the view: both robots on the left, plots on the right."""
    space = rrb.Spatial3DView(
        origin="/",
        contents=["/a/**", "/b/**"],
        name=f"A blue: {names[0]}, B orange: {names[1]}; elastic displacement ×{scale:g}",
        background=rrb.Background((24, 27, 33)),
        eye_controls=robot.eye(reach),
    )
    plots = rrb.Vertical(
        rrb.TimeSeriesView(origin="tip", name="Tip deflection, mm"),
        rrb.TimeSeriesView(origin="joints", name="Joint position, rad or m"),
        rrb.TimeSeriesView(origin="between", name="Distance of the tips, mm"),
    )
    return window(rrb.Horizontal(space, plots, column_shares=[3, 2]))
