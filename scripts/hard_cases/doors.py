"""Hard fire doors."""

from __future__ import annotations

from typing import Any

import numpy as np

from thermal_node import load_scene, simulate

from .case import Case, Outcome

BALANCE = 1e-6  # of the heat that crossed the surfaces, in every step
WOOL = {
    "density": 120.0,
    "specific_heat": 1000.0,
    "conductivity": {"temperature": [10, 100, 300, 600, 1000], "value": [0.035, 0.043, 0.073, 0.118, 0.178]},
}


def column(layers: list[tuple[str, float]], bricks: list[int], **keys: Any) -> dict[str, Any]:
    """Layers of steel and wool as a column through the thickness."""
    return {
        "model": "fire_door",
        "name": "hard",
        "leaf": {
            "height": 2.0,
            "width": 1.0,
            "layers": [{"material": m, "thickness": t} for m, t in layers],
        },
        "materials": {"rock_wool": WOOL},
        "furnace": {"curve": "iso_834"},
        "exposed": {"film_coefficient": 25.0, "emissivity": 0.8},
        "unexposed": {"film_coefficient": 10.0, "emissivity": 0.0},
        "ambient": 20.0,
        "mesh": {"layers": bricks},
        "solver": {"model": "column", "step": "auto"},
        **keys,
    }


SANDWICH = [("steel", 1e-3), ("rock_wool", 0.058), ("steel", 1e-3)]


def burn(
    scene: dict[str, Any], duration: float = 3600.0, period: float = 60.0, coldest: float = 19.0
) -> Outcome:
    """Finite, within what furnace and room allow, its heat balanced in every step."""
    run = simulate(load_scene(scene), duration=duration, sample_period=period)
    low, high = float(np.min(run.temperature)), float(np.max(run.temperature))
    held = (
        run.status.ok
        and bool(np.all(np.isfinite(run.temperature)))
        and run.balance.worst < BALANCE
        and low >= coldest
        and high <= max(float(np.max(run.furnace)), 20.0) + 1.0
    )
    figures = {"coldest, °C": low, "hottest, °C": high, "balance": float(run.balance.worst)}
    return Outcome(held, str(run.status), figures)


def refused(scene: dict[str, Any], *words: str) -> Outcome:
    """Not simulated: refused with words that say where."""
    try:
        run = simulate(load_scene(scene), duration=120.0, sample_period=60.0)
    except ValueError as problem:
        return Outcome(any(w in str(problem) for w in words), f"refused: {problem}")
    return Outcome(False, f"was not refused: {run.status}")


def measured(time: list[float], temperature: list[Any]) -> dict[str, Any]:
    return {"curve": "measured", "time": time, "temperature": temperature}


def jump() -> dict[str, Any]:
    """A conductivity that falls by 1e4 within one degree."""
    scene = column([("steel", 1e-3), ("odd", 0.058), ("steel", 1e-3)], [1, 12, 1])
    conductivity = {"temperature": [20, 300, 301, 1000], "value": [100.0, 100.0, 0.01, 0.01]}
    scene["materials"] = {"odd": {"density": 500.0, "specific_heat": 1000.0, "conductivity": conductivity}}
    return scene


def peak() -> dict[str, Any]:
    return column([("steel", 0.02)], [4], solver={"model": "column", "step": 60.0})


def cooling() -> dict[str, Any]:
    return column(
        SANDWICH,
        [1, 12, 1],
        furnace=measured([0, 60, 1800, 1860, 3600], [20, 400, 900, 20, 20]) | {"longest_gap": 2000.0},
    )


CASES = [
    Case(
        "peak_at_735",
        "steel's specific heat rises eightfold within 20 °C, and steps of 60 s jump over it",
        "heat balanced to 1e-6 in every step",
        lambda: burn(peak()),
    ),
    Case(
        "thin_sheets_thick_wool",
        "sheets of 0.1 mm answer in seconds, 200 mm of wool in hours",
        "heat balanced, within furnace and room",
        lambda: burn(column([("steel", 1e-4), ("rock_wool", 0.2), ("steel", 1e-4)], [1, 20, 1])),
    ),
    Case(
        "one_element_a_layer",
        "the whole wool is one element",
        "heat balanced, within furnace and room",
        lambda: burn(column(SANDWICH, [1, 1, 1])),
    ),
    Case(
        "hydrocarbon_first_second",
        "the furnace's temperature rises by hundreds of degrees in the first minute",
        "heat balanced, within furnace and room",
        lambda: burn(column(SANDWICH, [1, 12, 1], furnace={"curve": "hydrocarbon"}), 10.0, 1.0),
    ),
    Case(
        "cooling_after_fire",
        "the furnace falls by 900 °C within a minute: heat turns round inside the leaf",
        "heat balanced, never colder than the room",
        lambda: burn(cooling()),
    ),
    Case(
        "conductivity_jump_1e4",
        "a material that turns from metal to wool within one degree",
        "heat balanced, within furnace and room",
        lambda: burn(jump()),
    ),
    Case(
        "emissivity_0",
        "convection alone",
        "heat balanced, within furnace and room",
        lambda: burn(column(SANDWICH, [1, 12, 1], exposed={"film_coefficient": 25.0, "emissivity": 0.0})),
    ),
    Case(
        "emissivity_1",
        "black surfaces: radiation steepest",
        "heat balanced, within furnace and room",
        lambda: burn(
            column(
                SANDWICH,
                [1, 12, 1],
                exposed={"film_coefficient": 25.0, "emissivity": 1.0},
                unexposed={"film_coefficient": 10.0, "emissivity": 1.0},
            )
        ),
    ),
    Case(
        "furnace_at_minus_40",
        "a furnace colder than the room: heat flows outwards",
        "heat balanced, between furnace and room",
        lambda: burn(
            column(SANDWICH, [1, 12, 1], furnace={"curve": "constant", "temperature": -40.0}),
            3600.0,
            60.0,
            -41.0,
        ),
    ),
    Case(
        "gap_in_furnace_log",
        "ten minutes missing in a logged furnace",
        "refused, with the place of the gap",
        lambda: refused(
            column(SANDWICH, [1, 12, 1], furnace=measured([0, 60, 660, 720], [20, 300, 700, 710])),
            "gap",
            "longest_gap",
        ),
    ),
    Case(
        "nan_in_furnace_log",
        "a thermocouple that failed",
        "refused, with its place",
        lambda: refused(
            column(SANDWICH, [1, 12, 1], furnace=measured([0, 60, 120], [20, float("nan"), 500])),
            "finite",
            "nan",
        ),
    ),
    Case(
        "zero_conductivity",
        "k = 0 in a table",
        "refused, with its place",
        lambda: refused(
            {
                **jump(),
                "materials": {
                    "odd": {
                        "density": 500.0,
                        "specific_heat": 1000.0,
                        "conductivity": {"temperature": [20, 300], "value": [1.0, 0.0]},
                    }
                },
            },
            "conductivity",
            "more than",
        ),
    ),
]
