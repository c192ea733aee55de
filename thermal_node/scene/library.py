"""Materials whose every value has a source that was at hand; docs/materials.md is made of them.

What is not here was left out because its values could not be traced: gypsum and vermiculite boards, glass
wool, ceramic fibre, ceramic glass, intumescent strips. A scene gives those as its own tables.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

SLABS = "firemodels/fds, Validation/Insulation_Materials, stone_wool_const_AEn_{} (US government work)"
FIRES = "firemodels/fds, Validation/WTC, WTC_05 (US government work)"
SPRAYED = f"{FIRES}, there from NIST NCSTAR 1-6A, tables 6-4 and 6-5"
STAINLESS = "EN 1993-1-2:2005 Annex C"


@dataclass(frozen=True)
class Entry:
    """One material: what it is, its keys as a scene has them, and the source of each."""

    title: str
    keys: dict[str, Any]
    sources: dict[str, str]


def _stone_wool(
    number: int, density: float, binder: float, heat: tuple[float, float], conductivity: list[float]
) -> Entry:
    """A slab; heat : its specific heat at 20 and 1000 °C, J/(kg K).

    The binder's rate, 0.028 1/s exp(-21.7 kJ/mol / RT) Y^0.71, is of Y, its share of the whole layer's mass.
    """
    source = SLABS.format(number)
    kinetics = {
        "frequency_factor": 0.028 * binder ** (0.71 - 1.0),
        "activation_energy": 21700.0,
        "order": 0.71,
    }
    reaction = {
        "name": "binder",
        "share": binder,
        "residue": 0.283,
        "heat_of_combustion": 2.5e7,
        "specific_heat": 1700.0,
        "kinetics": kinetics,
    }
    return Entry(
        f"stone wool, {density:g} kg/m3, {100.0 * binder:g} % binder that burns",
        {
            "density": density,
            "specific_heat": {"temperature": [20.0, 1000.0], "value": list(heat), "beyond": "hold"},
            "conductivity": {
                "temperature": [20.0, *(100.0 * n for n in range(1, 11))],
                "value": conductivity,
            },
            "reactions": [reaction],
        },
        {
            "density": source,
            "specific_heat": source + ", its two ends",
            "conductivity": source,
            "reactions": source + ", oxygen unlimited",
        },
    )


def _stainless() -> Entry:
    t = [20.0 * n for n in range(1, 61)]
    return Entry(
        "stainless steel",
        {
            "density": 7850.0,
            "specific_heat": {
                "temperature": t,
                "value": [450.0 + 0.280 * x - 2.91e-4 * x**2 + 1.34e-7 * x**3 for x in t],
                "beyond": "hold",
            },
            "conductivity": {"temperature": t, "value": [14.6 + 1.27e-2 * x for x in t], "beyond": "hold"},
            "elongation": {
                "temperature": t,
                "value": [(16.0 + 4.79e-3 * x - 1.243e-6 * x**2) * (x - 20.0) * 1e-6 for x in t],
                "beyond": "extend",
            },
        },
        {
            "density": "EN 1993-1-2:2005 clause 3.2.2, as for carbon steel",
            "specific_heat": STAINLESS + ", (C.2)",
            "conductivity": STAINLESS + ", (C.3)",
            "elongation": STAINLESS + ", (C.1)",
        },
    )


def _board() -> Entry:
    """Marinite I, as in NIST's fires for the World Trade Center."""
    return Entry(
        "calcium silicate board, 737 kg/m3 (BNZ Marinite I)",
        {
            "density": 737.0,
            "specific_heat": {
                "temperature": [93.0, 205.0, 316.0, 425.0],
                "value": [1172.0, 1255.0, 1339.0, 1423.0],
                "beyond": "hold",
            },
            "conductivity": {"temperature": [24.0, 149.0, 538.0], "value": [0.13, 0.12, 0.12]},
        },
        {"density": FIRES, "specific_heat": f"{FIRES}, held above as there", "conductivity": FIRES},
    )


def _sprayed() -> Entry:
    return Entry(
        "sprayed mineral fibre, 208 kg/m3 (Isolatek Blaze-Shield DC/F)",
        {
            "density": 208.0,
            "specific_heat": {
                "temperature": [25.0, 100.0, 300.0, 500.0, 800.0, 1200.0],
                "value": [830.0, 940.0, 720.0, 900.0, 1020.0, 1070.0],
            },
            "conductivity": {
                "temperature": [25.0, 100.0, 300.0, 500.0, 800.0, 1200.0],
                "value": [0.046, 0.063, 0.11, 0.17, 0.34, 0.53],
            },
        },
        {"density": FIRES, "specific_heat": SPRAYED, "conductivity": SPRAYED},
    )


LIBRARY: dict[str, Entry] = {
    "stone_wool_38": _stone_wool(
        20, 38.0, 0.007, (994.9, 1143.8),
        [0.0362, 0.0528, 0.0813, 0.1209, 0.1741, 0.2434, 0.3313, 0.4402, 0.5726, 0.7306, 0.9168],
    ),
    "stone_wool_65": _stone_wool(
        23, 64.7, 0.09, (995.8, 1148.4),
        [0.0321, 0.0441, 0.0632, 0.0883, 0.1210, 0.1627, 0.2148, 0.2787, 0.3557, 0.4470, 0.5541],
    ),
    "stone_wool_96": _stone_wool(
        4, 95.8, 0.012, (996.1, 1149.8),
        [0.0422, 0.0525, 0.0699, 0.0935, 0.1249, 0.1652, 0.2159, 0.2784, 0.3538, 0.4435, 0.5487],
    ),
    "stone_wool_100": _stone_wool(
        1, 99.9, 0.015, (996.1, 1150.0),
        [0.0305, 0.0405, 0.0555, 0.0744, 0.0982, 0.1280, 0.1646, 0.2090, 0.2621, 0.3246, 0.3974],
    ),
    "calcium_silicate_737": _board(),
    "sprayed_fibre_208": _sprayed(),
    "stainless_steel": _stainless(),
}  # fmt: skip
