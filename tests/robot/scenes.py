"""Small scenes for the tests, as dicts."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

CONFIG = Path(__file__).parents[2] / "config"
DATA = Path(__file__).parent / "data"
STEEL = {"density": 7800.0, "youngs_modulus": 2.0e11, "poissons_ratio": 0.33, "elements": 2}


def link(name: str, dh: dict, width=0.03, depth=0.01, joint=None, beam=None, **keys) -> dict:
    """A link with a rectangular steel beam, or without one where width is None."""
    made: dict[str, Any] = {"name": name, "dh": dh}
    if joint is not None:
        made["joint"] = joint
    if width is not None:
        made["beam"] = {**STEEL, "width": width, "depth": depth, **(beam or {})}
    return {**made, **keys}


def robot(*links: dict, **keys) -> dict:
    """A scene of these links."""
    return {"model": "robot", "name": "test", "links": [copy.deepcopy(x) for x in links], **keys}


def two_link(**keys) -> dict:
    """Table 2.3 of the thesis: the planar double pendulum, undamped."""
    table = {"density": 7840.0, "poissons_ratio": 0.3}
    return robot(
        link("link_1", {"a": 0.5}, 0.03, 0.01, beam=table),
        link("link_2", {"a": 0.5}, 0.01, 0.03, beam=table),
        **{"gravity": [0.0, -9.81, 0.0], **keys},
    )


def anthropomorphic(**keys) -> dict:
    """Table 2.2 of the thesis with link 1's long side along joint 2's axis, as the reference has
    it.
    """
    right_angle = 1.5707963267948966
    return robot(
        link("link_1", {"d": 0.5, "alpha": right_angle}, 0.01, 0.03),
        link("link_2", {"a": 0.5}, 0.01, 0.03),
        link("link_3", {"a": 0.5}, 0.01, 0.03),
        **keys,
    )
