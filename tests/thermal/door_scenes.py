"""Scenes that several tests burn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

DATA = Path(__file__).parent / "data"

CALIBRATED_WOOL = [0.035, 0.043, 0.073, 0.17, 0.30]
"""W/(m K) at 10, 100, 300, 600 and 1000 °C: the table of the reference data."""


def door(**changes: Any) -> dict[str, Any]:
    """The thesis' door, as the reference data has it; `changes` replace whole sections."""
    scene: dict[str, Any] = {
        "model": "fire_door",
        "name": "thesis_door",
        "leaf": {
            "height": 2.0,
            "width": 1.0,
            "layers": [
                {"material": "steel", "thickness": 0.001},
                {"material": "rock_wool", "thickness": 0.058},
                {"material": "steel", "thickness": 0.001},
            ],
            "rim": {"material": "steel", "thickness": 0.001},
        },
        "materials": {
            "rock_wool": {
                "density": 120.0,
                "specific_heat": 1000.0,
                "conductivity": {
                    "temperature": [10, 100, 300, 600, 1000],
                    "value": CALIBRATED_WOOL,
                },
            }
        },
        "furnace": {"curve": "iso_834"},
        "exposed": {"film_coefficient": 25.0, "emissivity": 0.8},
        "unexposed": {"film_coefficient": 10.0, "emissivity": 0.0},
        "ambient": 20.0,
        "mesh": {"in_plane": [20, 40], "layers": [1, 12, 1], "symmetry": "quarter"},
        "solver": {"model": "full", "step": "auto"},
    }
    return {**scene, **changes}


def slab(thickness: float, material: dict[str, Any], bricks: int, **changes: Any) -> dict[str, Any]:
    """One layer, solved as a column."""
    scene: dict[str, Any] = {
        "model": "fire_door",
        "name": "slab",
        "leaf": {
            "height": 1.0,
            "width": 1.0,
            "layers": [{"material": "stuff", "thickness": thickness}],
        },
        "materials": {"stuff": material},
        "mesh": {"layers": [bricks]},
        "solver": {"model": "column"},
    }
    return {**scene, **changes}
