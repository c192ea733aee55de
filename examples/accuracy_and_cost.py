"""Accuracy against cost: the error of a step length, and how many steps it takes."""

import tempfile
from pathlib import Path

import matplotlib
import numpy as np

from flexsim_node import load_scene, simulate

matplotlib.use("Agg")
from matplotlib import pyplot

CONFIG = Path(__file__).parents[1] / "config"
DURATION, PERIOD = 0.2, 0.008


def tip(step: float) -> np.ndarray:
    """Places of the tip under a smooth torque, with this step."""
    scene = load_scene(CONFIG / "planar_double_pendulum.yaml", {"gravity": [0, 0, 0], "solver.step": step})
    run = simulate(
        scene, lambda t: np.array([2.0 * np.sin(np.pi * t / DURATION) ** 2, 0.0]), DURATION, PERIOD
    )
    return run.link_end[:, -1]


steps = [0.008, 0.004, 0.002, 0.001]
finest = tip(0.000125)
errors = [1e3 * np.abs(tip(step) - finest).max() for step in steps]
print("step/ms   steps   error of the tip/mm   over the step before")
for k, (step, error) in enumerate(zip(steps, errors, strict=True)):
    ratio = f"{errors[k - 1] / error:8.2f}" if k else "       -"
    print(f"{1e3 * step:7.1f} {round(DURATION / step):7d} {error:21.6f} {ratio:>20}")
print("a method of second order: four times as exact with twice the steps")

figure, axes = pyplot.subplots(figsize=(5.0, 3.5), layout="constrained")
axes.loglog([DURATION / step for step in steps], errors, "o-")
axes.set(xlabel="steps", ylabel="error / mm")
out = Path(tempfile.mkdtemp()) / "accuracy.png"
figure.savefig(out)
print("picture:", out)
