"""URDFs drawn at random: trees with skew axes, offsets, full inertias, fixed links; the same for a seed."""

from __future__ import annotations

import numpy as np


def numbers(values) -> str:
    """As a URDF writes them."""
    return " ".join(repr(float(x)) for x in values)


def random_urdf(seed: int) -> str:
    """A robot with a branched tree of eleven links under a root."""
    rng = np.random.default_rng(seed)
    out = [f'<?xml version="1.0"?>\n<robot name="random_{seed}">', '<link name="root"/>']
    names = ["root"]
    for n in range(11):
        name, parent = f"link_{n}", str(rng.choice(names))
        kind = str(rng.choice(["revolute", "continuous", "prismatic", "fixed"], p=[0.3, 0.2, 0.15, 0.35]))
        kind = "revolute" if n == 0 else kind
        out.append(f'<link name="{name}">' + ("" if kind == "fixed" and n % 2 else inertial(rng)) + "</link>")
        out.append(
            f'<joint name="joint_{n}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>'
            f'<origin xyz="{numbers(rng.uniform(-0.4, 0.4, 3))}" rpy="{numbers(rng.uniform(-3, 3, 3))}"/>'
            f'<axis xyz="{numbers(unit(rng))}"/>'
            '<limit lower="-3" upper="3" effort="40" velocity="2"/></joint>'
        )
        names.append(name)
    return "\n".join([*out, "</robot>"])


def unit(rng: np.random.Generator) -> np.ndarray:
    """A direction."""
    axis = rng.standard_normal(3)
    return axis / np.linalg.norm(axis)


def inertial(rng: np.random.Generator) -> str:
    """A body with products of inertia, off the link's origin and turned."""
    mass = rng.uniform(0.2, 3.0)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    second = turn @ np.diag(rng.uniform(1e-4, 4e-3, 3)) @ turn.T
    i = mass * (np.trace(second) * np.eye(3) - second)
    keys = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    place, angles = rng.uniform(-0.2, 0.2, 3), rng.uniform(-3, 3, 3)
    return (
        f'<inertial><origin xyz="{numbers(place)}" rpy="{numbers(angles)}"/>'
        f'<mass value="{mass!r}"/><inertia '
        + " ".join(f'{k}="{float(x)!r}"' for k, x in keys.items())
        + "/></inertial>"
    )


BODY = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="2"/>'
    '<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def link(name: str, body: str = BODY) -> str:
    """A link."""
    return f'<link name="{name}">{body}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = "") -> str:
    """A joint 0.3 m up its parent."""
    axis = "" if kind == "fixed" or "<axis" in inside else '<axis xyz="0 1 0"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.3"/>{axis}{inside}</joint>'
    )


def robot(*parts: str) -> str:
    """A URDF of links and joints, with a root `ground`."""
    return "\n".join(['<robot name="r">', '<link name="ground"/>', *parts, "</robot>"])


ARM = robot(
    link("upper"), joint("shoulder", "ground", "upper"), link("fore"), joint("elbow", "upper", "fore"),
    link("tool", ""), joint("flange", "fore", "tool", "fixed"),
)  # fmt: skip
