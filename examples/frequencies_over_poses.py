"""Natural frequencies over the elbow's angle: a table and a picture."""

import tempfile
from pathlib import Path

import matplotlib
import numpy as np

from flexsim_node import load_scene, natural_frequencies

matplotlib.use("Agg")
from matplotlib import pyplot

CONFIG = Path(__file__).parents[1] / "config"

scene = load_scene(CONFIG / "anthropomorphic.yaml")
elbow = np.linspace(-2.5, 0.0, 11)
poses = np.column_stack([np.zeros_like(elbow), np.full_like(elbow, 0.6), elbow])
frequency = natural_frequencies(scene, poses)[:, :4]  # joints locked

print("elbow/rad   " + "   ".join(f"f{k + 1}/Hz" for k in range(4)))
for angle, row in zip(elbow[::2], frequency[::2], strict=True):
    print(f"{angle:9.2f} " + "".join(f"{value:8.2f}" for value in row))

figure, axes = pyplot.subplots(figsize=(6.0, 3.5), layout="constrained")
axes.plot(elbow, frequency)
axes.set(xlabel="elbow / rad", ylabel="natural frequency / Hz", ylim=(0.0, None))
out = Path(tempfile.mkdtemp()) / "frequencies.png"
figure.savefig(out)
print("picture:", out)
