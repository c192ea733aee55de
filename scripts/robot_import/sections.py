"""Beams in words: SECTION,MATERIAL,ELEMENTS to the keys of a scene's beam."""

from __future__ import annotations

import math
from typing import Any

# Young's modulus Pa, density kg/m3, Poisson's ratio
MATERIALS: dict[str, tuple[float, float, float]] = {
    "steel": (2.1e11, 7850.0, 0.3),  # EN 1993-1-1, 3.2.6, and EN 1991-1-1, A.4
    "aluminium": (7.0e10, 2700.0, 0.3),  # EN 1999-1-1, 3.2.5
    "titanium": (1.138e11, 4430.0, 0.342),  # Ti-6Al-4V: MIL-HDBK-5J, 5.4
}
FORMS = {
    "rectangle": "WIDTHxDEPTH",
    "round": "DIAMETER",
    "tube": "OUTSIDExWALL",
    "box": "WIDTHxDEPTHxWALL",
}


def beam_of(words: str) -> dict[str, Any]:
    """The beam that words such as tube:0.05x0.003,aluminium,4 mean; metres.

    Raises
    ------
    ValueError
        what is wrong, and what would be right
    """
    parts = [part.strip() for part in words.split(",")]
    if len(parts) not in (2, 3):
        raise ValueError(f"{words!r} is no beam; give SECTION,MATERIAL, such as tube:0.05x0.003,aluminium")
    beam = section_of(parts[0]) | material_of(parts[1])
    if len(parts) == 3:
        if not parts[2].isdigit() or int(parts[2]) < 1:
            raise ValueError(f"{parts[2]!r} is no number of elements; give 1 or more")
        beam["elements"] = int(parts[2])
    return beam


def section_of(words: str) -> dict[str, Any]:
    """Width and depth, or area and moments, of a section such as tube:0.05x0.003."""
    form, _, written = words.partition(":")
    known = " or ".join(f"{name}:{sizes}" for name, sizes in FORMS.items())
    if form not in FORMS:
        raise ValueError(f"{words!r} is no section; give {known}, in m")
    try:
        sizes = [float(size) for size in written.split("x")]
    except ValueError:
        sizes = []
    wanted = FORMS[form].count("x") + 1
    if len(sizes) != wanted or not all(0.0 < size <= 10.0 for size in sizes):
        raise ValueError(f"{words!r} has no {wanted} sizes from 0 to 10 m; give {form}:{FORMS[form]}, in m")
    if form == "rectangle":
        return {"width": sizes[0], "depth": sizes[1]}
    wall = sizes[-1]
    if form in ("tube", "box") and 2.0 * wall >= min(sizes[:-1]):
        raise ValueError(f"{words!r} has a wall that fills it; give a thinner one, or a full section")
    if form == "box":
        (w, d), t = sizes[:2], wall
        inner_w, inner_d = w - 2.0 * t, d - 2.0 * t
        around = (w - t) * (d - t)
        return {
            "area": w * d - inner_w * inner_d,
            "iy": (w * d**3 - inner_w * inner_d**3) / 12.0,
            "iz": (d * w**3 - inner_d * inner_w**3) / 12.0,
            "j": 2.0 * t * around**2 / (w + d - 2.0 * t),  # Bredt's second formula, of a thin wall
        }
    outer, inner = sizes[0], sizes[0] - 2.0 * wall if form == "tube" else 0.0
    second = math.pi / 64.0 * (outer**4 - inner**4)
    area = math.pi / 4.0 * (outer**2 - inner**2)
    return {"area": area, "iy": second, "iz": second, "j": 2.0 * second}


def material_of(words: str) -> dict[str, Any]:
    """Stiffness and density of a material by name, or by E:DENSITY:POISSON."""
    if words in MATERIALS:
        modulus, density, ratio = MATERIALS[words]
    else:
        try:
            given = [float(word) for word in words.split(":")]
            modulus, density, ratio = given if len(given) == 3 else [*given, 0.3]
        except ValueError:
            raise ValueError(
                f"{words!r} is no material; give {', '.join(MATERIALS)}, or E:DENSITY:POISSON, such as"
                " 6.9e10:2700:0.33"
            ) from None
    return {"density": density, "youngs_modulus": modulus, "poissons_ratio": ratio}
