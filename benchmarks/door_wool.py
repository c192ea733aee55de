"""How much the wool's conductivity above 300 °C decides: the picture in docs/door.md.

python benchmarks/door_wool.py [PICTURE.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from matplotlib.figure import Figure

from thermal_node import load_scene, simulate

ROOT = Path(__file__).resolve().parents[1]
CONTINUATIONS = {
    "held at 300 °C's": [0.035, 0.043, 0.073, 0.073, 0.073],
    "last slope (thesis_door.yaml)": [0.035, 0.043, 0.073, 0.118, 0.178],
    "steeper (thesis_door_calibrated.yaml)": [0.035, 0.043, 0.073, 0.17, 0.30],
}


def main() -> None:
    """Burn the door with each continuation; print a table and draw the curves."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture", nargs="?", default=str(ROOT / "docs/images/door_wool.png"))
    picture = parser.parse_args().picture
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    table, curves = figure.subplots(1, 2)
    for name, value in CONTINUATIONS.items():
        scene = load_scene(
            ROOT / "config/thesis_door.yaml",
            {
                "materials.rock_wool.conductivity.value": value,
                "deformation.model": "none",
            },
        )
        run = simulate(scene)
        table.plot([10, 100, 300, 600, 1000], value, label=name)
        curves.plot(run.time / 60, run.probes["ftp_centre"])
        print(f"{name:40}{run.probes['ftp_centre'][-1]:8.1f} °C  {run.verdict}")
    curves.axhline(160.0, color="firebrick", linestyle="--")
    curves.text(1.0, 163.0, "20 + 140 °C", color="firebrick", fontsize=8)
    table.set(xlabel="°C", ylabel="W/(m K)", title="Conductivity of the wool")
    curves.set(xlabel="min", ylabel="°C", title="Middle of the unexposed face")
    table.legend(fontsize=8)
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main()
