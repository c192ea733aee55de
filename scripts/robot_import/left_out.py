"""Elements and attributes of a URDF that an import does not read, counted, so that it can say so."""

from __future__ import annotations

from collections import Counter

from .xml_file import Element

INERTIA = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}
ATTRIBUTES: dict[str, set[str]] = {
    "link": {"name"}, "inertial": set(), "mass": {"value"}, "inertia": INERTIA,
    "origin": {"xyz", "rpy"}, "visual": {"name"}, "geometry": set(), "mesh": {"filename", "scale"},
    "joint": {"name", "type"}, "parent": {"link"}, "child": {"link"}, "axis": {"xyz"},
    "limit": {"lower", "upper", "effort", "velocity"}, "dynamics": {"damping", "friction"},
    "mimic": {"joint", "multiplier", "offset"},
}  # fmt: skip
CHILDREN: dict[str, set[str]] = {
    "link": {"inertial", "visual"},
    "inertial": {"origin", "mass", "inertia"},
    "visual": {"origin", "geometry"},
    "geometry": {"mesh"},
    "joint": {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"},
}
# what the account tells in words of its own: collision shapes, plain visuals, joints' extras
TOLD = {"collision", "box", "cylinder", "sphere", "capsule", "calibration", "safety_controller"}
OF_MOTION = {"limit", "dynamics", "mimic"}


def left_out(robot: Element) -> Counter[str]:
    """How often each is there: `<TAG>`, `<TAG> in <PARENT>` or `ATTRIBUTE of <TAG>`."""
    found: Counter[str] = Counter()
    for child in robot.children:
        if child.tag not in ("link", "joint"):
            found[f"<{child.tag}>"] += 1
            continue
        waiting = [child]
        while waiting:
            element = waiting.pop()
            still = element.tag == "joint" and element.attributes.get("type") == "fixed"
            found.update(f"{k} of <{element.tag}>" for k in set(element.attributes) - ATTRIBUTES[element.tag])
            for below in element.children:
                if still and below.tag in OF_MOTION:
                    found[f"<{below.tag}> in fixed <joint>"] += 1
                elif below.tag in CHILDREN.get(element.tag, ()):
                    waiting.append(below)
                elif below.tag not in TOLD:
                    found[f"<{below.tag}> in <{element.tag}>"] += 1
    return found
