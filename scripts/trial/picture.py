"""The picture of a trial: the arm on its way, its joints, how its tip swings, how fast it does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsim_node import Scene, natural_frequencies

from ..bag import Bag
from ..controller import Move
from ..figures.style import BLUE, COLOURS, GHOST, GRID, INK, ORANGE, styled
from .figures import Motion, motion

EXAGGERATION = 4.0
SHAPES = 7
MILLIMETRES = 1e3
HIGHEST = 30.0  # Hz


def draw(bag: Path, scene: Scene, move: Move, until: float, file: Path) -> None:
    """Draw a trial's picture into a PNG."""
    moved = motion(Bag(bag), until)
    with styled() as pyplot:
        figure = pyplot.figure(figsize=(14.0, 8.0), layout="constrained")
        grid = figure.add_gridspec(3, 2, width_ratios=[1.0, 1.15], height_ratios=[1.0, 1.25, 1.0])
        arm(figure.add_subplot(grid[:, 0], projection="3d"), moved, move)
        angles = figure.add_subplot(grid[0, 1])
        joints(angles, moved, move, scene.joint_names)
        swing(figure.add_subplot(grid[1, 1], sharex=angles), moved, move)
        spectrum(figure.add_subplot(grid[2, 1]), moved, move, scene)
        figure.suptitle(
            "An arm of steel links, simulated in real time, under joint PD control",
            x=0.01, ha="left", fontsize=14, fontweight="bold",
        )  # fmt: skip
        figure.savefig(file, dpi=110)
        pyplot.close(figure)


def arm(axes: Any, moved: Motion, move: Move) -> None:
    """Draw the arm at some instants of its way, bent and as the rigid links lie."""
    times = np.linspace(move.there, move.there + move.time, SHAPES)
    at = np.clip(np.searchsorted(moved.elastic_time, times), 0, len(moved.elastic_time) - 1)
    rigid = moved.rigid_position[at]
    shown = rigid + EXAGGERATION * (moved.position[at] - rigid)
    window = (moved.elastic_time >= move.there) & (moved.elastic_time <= move.back)
    tip = moved.rigid_position[window, -1] + EXAGGERATION * (
        moved.position[window, -1] - moved.rigid_position[window, -1]
    )
    axes.plot(*tip.T, color=ORANGE, linewidth=0.9, alpha=0.9, label="path of the tip, until it moves back")
    for n in range(SHAPES):
        fade = 0.25 + 0.75 * n / (SHAPES - 1)
        axes.plot(*rigid[n].T, color=GHOST, linewidth=1.4, label="rigid links" if n == 0 else None)
        axes.plot(
            *shown[n].T, color=BLUE, alpha=fade, linewidth=2.6, solid_capstyle="round",
            label=f"flexible links, displacement ×{EXAGGERATION:g}" if n == SHAPES - 1 else None,
        )  # fmt: skip
    everything = np.concatenate([rigid.reshape(-1, 3), shown.reshape(-1, 3)])
    low, high = everything.min(axis=0), everything.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(0.0, high[2]))
    axes.set_aspect("equal")
    axes.set(xlabel="x, m", ylabel="y, m")
    axes.set_zlabel("z, m", labelpad=10.0)  # else it lies on the ticks
    axes.set_title(f"The way there, {move.time:g} s")
    axes.view_init(elev=22, azim=-52)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_major_locator(_few_ticks())
    axes.legend(loc="upper left", fontsize=9)


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)


def joints(axes: Any, moved: Motion, move: Move, names: tuple[str, ...]) -> None:
    """Plot the joints, wanted and measured."""
    for k, name in enumerate(names):
        colour = COLOURS[(5, 6, 2)[k % 3]]
        axes.plot(moved.time, moved.joint_position[:, k], color=colour, label=name.replace("_", " "))
    for k, wanted in enumerate(move.position(moved.time).T):
        label = None if k else "wanted"
        axes.plot(moved.time, wanted, color=INK, linewidth=0.7, linestyle=":", label=label)
    axes.set(ylabel="rad", title="Joints")
    axes.legend(loc="upper right", ncols=len(names) + 1, fontsize=9, bbox_to_anchor=(1.0, 1.2))


def swing(axes: Any, moved: Motion, move: Move) -> None:
    """Plot the tip's elastic displacement across its link."""
    tip = MILLIMETRES * moved.displacement[:, -1]
    for begin in (move.there, move.back):
        axes.axvspan(begin, begin + move.time, color=GRID, alpha=0.6, linewidth=0)
    axes.plot(moved.elastic_time, tip[:, 2], color=BLUE, label="sideways")
    axes.plot(moved.elastic_time, tip[:, 1], color=ORANGE, label="in the arm's plane")
    deflection = MILLIMETRES * moved.tip_deflection
    rms, peak = np.sqrt(np.mean(deflection**2)), deflection.max()
    axes.set(
        ylabel="mm", xlabel="simulated time, s", xlim=(0.0, moved.time[-1]),
        title=f"Tip deflection: rms {rms:.1f} mm, peak {peak:.1f} mm",
    )  # fmt: skip
    axes.legend(loc="upper right", ncols=2, fontsize=9, bbox_to_anchor=(1.0, 1.16))


def spectrum(axes: Any, moved: Motion, move: Move, scene: Scene) -> None:
    """Plot the spectrum of the swinging after the way there, over the natural frequencies."""
    rest = (moved.elastic_time > move.there + move.time) & (moved.elastic_time < move.back)
    time, tip = moved.elastic_time[rest], MILLIMETRES * moved.displacement[rest, -1]
    label = "natural frequencies, joints locked"
    for n, frequency in enumerate(natural_frequencies(scene, np.array(move.goal))):
        if frequency < HIGHEST:
            words = None if n else label
            axes.axvline(frequency, color=GHOST, linewidth=1.0, linestyle="--", label=words)
    for column, colour, name in ((2, BLUE, "sideways"), (1, ORANGE, "in the arm's plane")):
        frequency, amplitude = amplitudes(time, tip[:, column])
        axes.semilogy(frequency, amplitude, color=colour, label=name)
    top = axes.get_ylim()[1]
    axes.set(xlim=(0.0, HIGHEST), ylim=(1e-4 * top, top), xlabel="Hz", ylabel="mm",
             title="Spectrum of the swinging after the way there")  # fmt: skip
    axes.legend(loc="upper right", fontsize=9)


def amplitudes(
    time: NDArray[np.float64], value: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return frequencies, Hz, and amplitudes of an even signal, padded for a smooth curve."""
    period = float(np.median(np.diff(time)))
    window = np.hanning(len(value))
    padded = 8 * len(value)
    transformed = np.fft.rfft((value - value.mean()) * window, padded)
    amplitude = 2.0 * np.abs(transformed) / window.sum()
    return np.fft.rfftfreq(padded, period).astype(float), np.asarray(amplitude, dtype=float)
