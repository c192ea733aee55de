"""Where the joints of a URDF are at the start: held, in the middle of their limits, following others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .urdf import Urdf, UrdfJoint
from .xml_file import ImportRefused


@dataclass
class Rest:
    """Positions (rad or m) by joint: of those that are held, and of all others where they start."""

    held: dict[str, float] = field(default_factory=dict)
    starts: dict[str, float] = field(default_factory=dict)


def rest_of(urdf: Urdf, hold: Mapping[str, float], hold_mimics: bool) -> Rest:
    """Where each joint that can move is held or starts.

    Raises
    ------
    ImportRefused
        where a joint to be held is none that can move
    """
    joints = {joint.name: joint for joint in urdf.joints if joint.kind != "fixed"}
    for name in hold:
        if name not in joints:
            raise ImportRefused(
                f"--hold {name}: is no joint that can move; give one of {', '.join(joints) or 'none'}"
            )

    def place(joint: UrdfJoint | None) -> float:
        factor, offset = 1.0, 0.0
        while joint is not None and joint.name not in hold and joint.mimic:
            factor, offset = factor * joint.multiplier, offset + factor * joint.offset
            joint = joints.get(joint.mimic)
        if joint is None:
            return offset  # it follows a fixed one, or one that is not in the file
        return offset + factor * (hold[joint.name] if joint.name in hold else middle(joint) or 0.0)

    found = Rest()
    for name, joint in joints.items():
        held = name in hold or (bool(joint.mimic) and hold_mimics)
        (found.held if held else found.starts)[name] = place(joint)
    return found


def middle(joint: UrdfJoint) -> float | None:
    """The middle of limits that leave out 0."""
    lower, upper = joint.lower or 0.0, joint.upper or 0.0
    if joint.kind == "continuous" or lower <= 0.0 <= upper:
        return None
    return 0.5 * (lower + upper)


def outside(joint: UrdfJoint, position: float) -> bool:
    """Whether a position is beyond a joint's limits, if it has any."""
    lower, upper = joint.lower, joint.upper
    if joint.kind == "continuous" or (lower is None and upper is None):
        return False
    return not (lower or 0.0) - 1e-9 <= position <= (upper or 0.0) + 1e-9
