"""Robots whose loads act on bent ends: what `independent_frame` is asked about, as dicts.

Deep strips of aluminium: stiff in the plane of their load, soft across it. So rotations stay small (no more
than a few hundredths of a radian) where loads change the frequencies by a tenth and more.
"""

from __future__ import annotations

import numpy as np
from scenes import robot

RIGHT_ANGLE = 0.5 * np.pi
DOWN = [0.0, -9.81, 0.0]
ALUMINIUM = {"density": 2700.0, "youngs_modulus": 7.0e10, "poissons_ratio": 0.3, "elements": 6}
FIXED = {"type": "fixed"}


def part(name, dh, width=None, depth=None, joint=None, **keys):
    """A link with a strip, or without a beam where width is None."""
    made = {"name": name, "dh": dh, **keys}
    if joint is not None:
        made["joint"] = joint
    if width is not None:
        made["beam"] = {**ALUMINIUM, "width": width, "depth": depth}
    return made


def body(mass, center=(0.0, 0.0, 0.0), size=1e-4):
    """A payload with products of inertia."""
    inertia = size * mass * np.array([[1.0, 0.1, 0.0], [0.1, 1.2, -0.2], [0.0, -0.2, 0.9]])
    return {"mass": mass, "center_of_mass": list(center), "inertia": inertia.tolist()}


ARM = part("arm", {"a": 0.5}, 0.03, 0.002)
WEIGHED = {
    "deep strip": robot(part("arm", {"a": 0.5}, 0.03, 0.002, payload=body(2.0)), gravity=DOWN),
    "payload above": robot({**ARM, "payload": body(1.0, (0.0, 0.1, 0.0))}, gravity=DOWN),
    "payload below": robot({**ARM, "payload": body(1.0, (0.0, -0.1, 0.0))}, gravity=DOWN),
    "payload off in three directions": robot(
        {**ARM, "payload": body(0.5, (0.06, 0.08, -0.01))}, gravity=DOWN
    ),
    "rigid body": robot(
        ARM, part("tool", {"a": 0.1}, joint=FIXED, rigid=body(0.5, (0.05, 0.08, 0.01))), gravity=DOWN
    ),
    "rigid link": robot(
        ARM,
        part("outer", {"a": 0.2}, 0.03, 0.02, {"name": "elbow"}, flexible=False, payload=body(0.5)),
        gravity=DOWN,
    ),
    "rigid link, bent up": robot(
        ARM,
        part("outer", {"a": 0.2}, 0.03, 0.02, {"name": "elbow"}, flexible=False, payload=body(0.5)),
        gravity=DOWN,
        initial={"position": [0.0, 1.2]},
    ),
    "L in the plane, up": robot(
        ARM,
        part("leg", {"a": 0.2, "theta": RIGHT_ANGLE}, 0.03, 0.004, FIXED, payload=body(1.0)),
        gravity=DOWN,
    ),
    "L in the plane, down": robot(
        ARM,
        part("leg", {"a": 0.2, "theta": -RIGHT_ANGLE}, 0.03, 0.004, FIXED, payload=body(1.0)),
        gravity=DOWN,
    ),
    "L across": robot(
        part("arm", {"a": 0.5, "alpha": RIGHT_ANGLE}, 0.02, 0.01),
        part("leg", {"a": 0.3, "theta": RIGHT_ANGLE}, 0.004, 0.02, FIXED, payload=body(2.0)),
        gravity=DOWN,
    ),
    "column with a link across": robot(
        part("column", {"a": 0.5}, 0.012, 0.008),
        part("across", {"a": 0.2, "theta": -RIGHT_ANGLE}, 0.02, 0.01, FIXED, payload=body(1.5)),
        gravity=DOWN,
        initial={"position": [RIGHT_ANGLE]},
    ),
    "column with a rigid link on top": robot(
        part("column", {"a": 0.5}, 0.008, 0.008),
        part("top", {"a": 0.25}, 0.02, 0.02, FIXED, flexible=False, payload=body(1.5)),
        gravity=DOWN,
        initial={"position": [RIGHT_ANGLE]},
    ),
    "branch": robot(
        ARM,
        part("up", {"a": 0.15, "theta": 1.2}, 0.02, 0.006, FIXED, payload=body(0.4)),
        part(
            "down",
            {"a": 0.15, "theta": -0.7, "alpha": 0.5},
            0.02,
            0.006,
            {"name": "wrist"},
            parent="arm",
            payload=body(0.4),
        ),
        gravity=DOWN,
        initial={"position": [0.0, 0.3]},
    ),
    "prismatic, stretched out": robot(
        part("arm", {"a": 0.4, "alpha": RIGHT_ANGLE, "theta": RIGHT_ANGLE}, 0.002, 0.03),
        part("slide", {"a": 0.1}, 0.03, 0.01, {"name": "slide", "type": "prismatic"}, payload=body(1.0)),
        gravity=DOWN,
        initial={"position": [-RIGHT_ANGLE, 0.25]},
    ),
    "skew arm": robot(
        part("one", {"a": 0.3, "d": 0.1, "alpha": 0.7}, 0.012, 0.004),
        part("two", {"a": 0.25, "alpha": -0.4, "d": -0.05}, 0.006, 0.010, {"name": "two"}),
        part("three", {"a": 0.1}, joint={"name": "three"}, rigid=body(0.4, (0.03, 0.02, 0.05))),
        gravity=[3.0, -8.0, 4.0],
        initial={"position": [0.2, 0.5, -0.4]},
    ),
}
"""Weight changes their frequencies at first order."""


def spun(*links, **keys):
    return robot(*links, gravity=[0.0, 0.0, 0.0], **keys)


STRIP = part("strip", {"a": 0.6}, 0.03, 0.002)
SPUN = {
    "strip": (spun(STRIP), 60.0),
    "body beyond the tip": (spun(STRIP, part("boom", {"a": 0.25}, joint=FIXED, rigid=body(0.05))), 40.0),
    "rigid link beyond the tip": (
        spun(STRIP, part("outer", {"a": 0.25}, 0.03, 0.004, FIXED, flexible=False)),
        40.0,
    ),
    "payload off in three directions": (spun({**STRIP, "payload": body(0.03, (0.05, 0.02, 0.01))}), 20.0),
    "swept tip": (
        spun(
            part("hub", {"a": 0.06}),
            part("strip", {"a": 0.6}, 0.025, 0.0016, FIXED),
            part("tip", {"a": 0.15, "theta": -0.7}, 0.025, 0.0016, FIXED),
        ),
        60.0,
    ),
    "drooped tip": (
        spun(
            part("strip", {"a": 0.5, "alpha": RIGHT_ANGLE}, 0.025, 0.003),
            part("tip", {"a": 0.1, "theta": 0.6}, 0.003, 0.02, FIXED),
        ),
        30.0,
    ),
    "branch": (
        spun(
            part("stem", {"a": 0.4}, 0.02, 0.004),
            part("left", {"a": 0.15, "theta": 0.8}, 0.02, 0.003, FIXED),
            part("right", {"a": 0.15, "theta": -0.8}, 0.02, 0.003, FIXED, parent="stem", payload=body(0.03)),
        ),
        40.0,
    ),
    "prismatic, stretched out": (
        spun(
            part("stem", {"a": 0.3, "alpha": RIGHT_ANGLE, "theta": RIGHT_ANGLE}, 0.004, 0.02),
            part("slide", {"a": 0.2}, 0.004, 0.02, {"name": "slide", "type": "prismatic"}),
            initial={"position": [0.0, -0.15]},
        ),
        30.0,
    ),
}
"""What a steady spin (rad/s) about the base's z axis does to them."""

ACROSS, ALONG = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
SIDE_LOADS = {
    "deep strip": ACROSS,
    "payload above": ACROSS,
    "rigid link, bent up": ACROSS,
    "branch": ACROSS,
    "column with a rigid link on top": ALONG,
    "column with a link across": ALONG,
}
"""Weighed scenes and the direction of a small load beside their weight."""

WRENCHES = {
    "push": [-3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "force in its plane": [0.0, -8.0, 0.0, 0.0, 0.0, 0.0],
    "moment in its plane": [0.0, 0.0, 0.0, 0.0, 0.0, 3.0],
    "torque": [0.0, 0.0, 0.0, 0.08, 0.0, 0.0],
}
"""On the last link's end, base axes, directions fixed; a small force across goes with them."""

RIGID_END = part("outer", {"a": 0.1}, joint=FIXED, rigid={"mass": 0.01})
LOADED_ENDS = {"strip": spun(STRIP), "rigid end": spun(STRIP, RIGID_END)}
