"""Robots drawn at random: serial, branched, closed and planar ones, the same for the same seed.

Axes are skew; joints turn, slide or are fixed, some behind springs; links bend, are rigid or have no length,
and carry bodies off their ends.  Nothing here is taken from flexsim_node: poses are the generator's own.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Scene = dict[str, Any]
KINDS = ("serial", "branched", "closed", "planar")
EQUATIONS = {"revolute": 5, "universal": 4, "spherical": 3, "slot": 2}


def random_robot(seed: int, kind: str = "serial", modulus: float = 2e11, **keys: Any) -> Scene:
    """A robot of a kind, as a scene.

    modulus : Young's modulus of the middle link, Pa; others have a third to three times of it
    keys : put over what was drawn
    """
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    flat = kind == "planar"
    if kind == "closed":
        links, loops = closed_links(rng, modulus)
    else:
        links, loops = open_links(rng, modulus, int(rng.integers(2, 5)), flat, kind == "branched"), []
    motors = [k for k in links if k["joint"]["type"] != "fixed"]
    down = rng.standard_normal(3) * ([1, 1, 0] if flat else 1)
    scene = {
        "model": "robot",
        "name": f"{kind}_{seed}",
        "gravity": (9.81 * down / np.linalg.norm(down)).tolist(),
        "links": links,
        "effects": {"shear": bool(rng.random() < 0.5), "rotary_inertia": bool(rng.random() < 0.9)},
        "initial": {"position": {k["joint"]["name"]: k.pop("start") for k in motors}},
        **({"loops": loops} if loops else {}),
    }
    return {**scene, **keys}


def body(rng: np.random.Generator, flat: bool, heavy: float = 1.0) -> Scene:
    """A rigid body with products of inertia, off the link's end."""
    mass = heavy * rng.uniform(0.1, 1.0)
    centre = rng.uniform(-0.1, 0.1, 3) * ([1, 1, 0] if flat else 1)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    if flat:
        turn[2], turn[:, 2] = 0.0, 0.0
        turn[2, 2] = 1.0
        angle = rng.uniform(0, 2 * np.pi)
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    second = turn @ np.diag(rng.uniform(1e-4, 3e-3, 3)) @ turn.T  # of mass along the axes
    inertia = mass * (np.trace(second) * np.eye(3) - second)
    return {
        "mass": mass,
        "center_of_mass": centre.tolist(),
        "inertia": (0.5 * (inertia + inertia.T)).tolist(),
    }


def link(rng: np.random.Generator, name: str, modulus: float, flat: bool, last: bool) -> Scene:
    """A link with its joint; the last of a chain always has mass."""
    made: Scene = {"name": name, "dh": {"theta": rng.uniform(-1, 1)}}
    dh = made["dh"]
    if not flat:
        dh["alpha"] = rng.uniform(-1.5, 1.5) if rng.random() < 0.8 else 0.0
    sort = rng.choice(["beam", "rigid beam", "wrist", "frame"], p=[0.7, 0.12, 0.12, 0.06])
    if last and sort == "frame":
        sort = "beam"
    if "beam" in sort:
        dh["a"] = rng.uniform(0.15, 0.5) * (-1 if rng.random() < 0.2 else 1)
        if not flat and rng.random() < 0.6:
            dh["d"] = rng.uniform(-0.3, 0.3)
        width, depth = np.exp(rng.uniform(np.log(0.008), np.log(0.03), 2))
        made["beam"] = {
            "width": width,
            "depth": depth,
            "density": rng.uniform(1000.0, 8000.0),
            "youngs_modulus": modulus * 3 ** rng.uniform(-1, 1),
            "poissons_ratio": rng.uniform(0.0, 0.45),
            "elements": int(rng.integers(1, 4)),
        }
        if sort == "rigid beam":
            made["flexible"] = False
    elif sort == "wrist":
        made["rigid"] = body(rng, flat)
    if rng.random() < 0.35:
        made["payload"] = body(rng, flat)
    made["joint"] = joint(rng, name, flat, "mass" if sort != "frame" else "none")
    if made["joint"]["type"] != "fixed":
        slides = made["joint"]["type"] == "prismatic"
        made["start"] = float(rng.uniform(-0.15, 0.15) if slides else rng.uniform(-1.5, 1.5))
    return made


def joint(rng: np.random.Generator, name: str, flat: bool, mass: str) -> Scene:
    """Turning, sliding or fixed, some with a rotor, some with a spring behind it."""
    kinds = ["revolute", "prismatic", "fixed"]
    chance = [0.85, 0.0, 0.15] if flat else [0.72, 0.15, 0.13]
    kind = str(rng.choice(kinds, p=chance)) if mass == "mass" else "fixed"
    if kind == "fixed":
        return {"type": "fixed"}
    made: Scene = {"type": kind, "name": f"{name}_joint"}
    if rng.random() < 0.4:
        made["rotor_inertia"], made["gear_ratio"] = rng.uniform(1e-5, 1e-3), rng.uniform(5.0, 30.0)
        if rng.random() < 0.6:
            made["stiffness"] = 10 ** rng.uniform(3, 5) * (10 if kind == "prismatic" else 1)
    return made


def open_links(rng: np.random.Generator, modulus: float, count: int, flat: bool, forked: bool) -> list[Scene]:
    """A chain, or a tree with three to six links, the first joint always moving."""
    count += 2 if forked else 0
    parents = [n - 1 for n in range(count)]
    if forked:
        parents[1:] = [int(rng.integers(-1, n)) for n in range(1, count)]
    links = []
    for n in range(count):
        last = n not in parents
        made = link(rng, "abcdefgh"[n], modulus, flat, last)
        if n == 0 and (made["joint"]["type"] == "fixed" or "beam" not in made):
            # one joint that moves something, at least
            made["dh"]["a"] = 0.3
            made.pop("rigid", None)
            made.setdefault(
                "beam", {"width": 0.02, "depth": 0.012, "density": 3000.0, "youngs_modulus": modulus}
            )
            made["joint"] = {"type": "revolute", "name": "a_joint"}
            made["start"] = float(rng.uniform(-1.5, 1.5))
        if forked:
            made["parent"] = "base" if parents[n] < 0 else links[parents[n]]["name"]
        links.append(made)
    return links


def closed_links(rng: np.random.Generator, modulus: float) -> tuple[list[Scene], list[Scene]]:
    """Two chains from the base whose ends meet in a joint where they happen to be."""
    while True:
        links: list[Scene] = []
        for side, count in (("a", int(rng.integers(2, 5))), ("b", int(rng.integers(2, 4)))):
            for n in range(count):
                made = link(rng, f"{side}{n}", modulus, False, n == count - 1)
                if n == 0 or (made["joint"]["type"] == "fixed" and rng.random() < 0.7 and "beam" in made):
                    made["joint"] = {"type": "revolute", "name": f"{side}{n}_joint"}
                    made.setdefault("start", float(rng.uniform(-1.5, 1.5)))
                if n == 0:
                    made["parent"] = "base"
                links.append(made)
        kind = str(rng.choice(list(EQUATIONS)))
        moving = [n for n, k in enumerate(links) if k["joint"]["type"] != "fixed"]
        # what moves nothing but itself can't be passive: a joint needs inertia beyond it
        if len(moving) <= EQUATIONS[kind]:
            continue
        loop = closing(rng, links, kind)
        passive = guided(links, loop, kind, moving, rng)
        if passive is None:
            continue
        for n in passive:
            links[n]["joint"] = {**plain(links[n]["joint"]), "actuated": False}
        return links, [loop]


def plain(joint: Scene) -> Scene:
    """A joint without motor."""
    return {key: joint[key] for key in ("type", "name")}


def closing(rng: np.random.Generator, links: list[Scene], kind: str) -> Scene:
    """A joint between the ends of both chains, which is closed at the start."""
    ends = poses(links)
    one, two = ends[last_of(links, "a")], ends[last_of(links, "b")]
    base = rng.standard_normal(3)
    base /= np.linalg.norm(base)
    beside = rng.uniform(-0.05, 0.05, 3)
    place = one[:3, 3] + one[:3, :3] @ beside
    at = {"one": beside, "two": two[:3, :3].T @ (place - two[:3, 3])}
    axis = {}
    if kind in ("revolute", "universal"):
        other = base
        if kind == "universal":
            other = np.cross(base, rng.standard_normal(3))
            other /= np.linalg.norm(other)
        axis = {"one": one[:3, :3].T @ base, "two": two[:3, :3].T @ other}
    if kind == "slot":
        axis = {"two": two[:3, :3].T @ base}
        at["two"] = at["two"] + 0.1 * rng.uniform(-1, 1) * axis["two"]
    names = {"one": links[last_of(links, "a")]["name"], "two": links[last_of(links, "b")]["name"]}
    return {
        "links": [names["one"], names["two"]],
        "joint": kind,
        "at": {names[k]: v.tolist() for k, v in at.items()},
        **({"axis": {names[k]: v.tolist() for k, v in axis.items()}} if axis else {}),
    }


def last_of(links: list[Scene], side: str) -> int:
    return max(n for n, k in enumerate(links) if k["name"].startswith(side))


def gap(links: list[Scene], loop: Scene) -> np.ndarray:
    """What the closing joint makes zero."""
    ends = dict(zip([k["name"] for k in links], poses(links), strict=True))
    one, two = (ends[name] for name in loop["links"])
    at, axis = ([loop.get(key, {}).get(name) for name in loop["links"]] for key in ("at", "axis"))
    apart = two[:3, :3].T @ (one[:3, 3] + one[:3, :3] @ at[0] - two[:3, 3]) - at[1]
    if loop["joint"] == "slot":
        across = np.linalg.svd(np.array(axis[1])[None])[2][1:]
        return across @ apart
    if loop["joint"] == "spherical":
        return apart
    first, second = one[:3, :3] @ axis[0], two[:3, :3] @ axis[1]
    if loop["joint"] == "universal":
        return np.append(apart, first @ second)
    across = np.linalg.svd(np.array(axis[1])[None])[2][1:] @ two[:3, :3].T
    return np.concatenate([apart, across @ first])


def guided(links, loop, kind, moving, rng) -> list[int] | None:
    """Joints that may be passive: the loop's equations determine them well; None where none do."""
    columns = []
    for n in moving:
        there = []
        for way in (1e-6, -1e-6):
            at = [{**k, "start": k["start"] + way} if i == n else k for i, k in enumerate(links)]
            there.append(gap(at, loop))
        columns.append((there[0] - there[1]) / 2e-6)
    jacobian = np.array(columns).T
    count = EQUATIONS[kind]
    best, chosen = 0.1, None
    for _ in range(40):
        some = sorted(rng.choice(len(moving), count, replace=False))
        least = np.linalg.svd(jacobian[:, some], compute_uv=False)[-1]
        if least > best:
            best, chosen = least, [moving[k] for k in some]
    return chosen


def poses(links: list[Scene], position: dict[str, float] | None = None) -> list[np.ndarray]:
    """(4, 4) of every link's end in the base frame, nothing deformed; at their starts, or at a position."""
    out: list[np.ndarray] = []
    ends = {"base": np.eye(4)}
    before = "base"
    for made in links:
        dh, q = made["dh"], 0.0
        if made["joint"]["type"] != "fixed":
            q = made["start"] if position is None else position[made["joint"]["name"]]
        slides = made["joint"]["type"] == "prismatic"
        theta = dh.get("theta", 0.0) + (0.0 if slides else q)
        c, s, ca, sa = (
            np.cos(theta),
            np.sin(theta),
            np.cos(dh.get("alpha", 0.0)),
            np.sin(dh.get("alpha", 0.0)),
        )
        a, d = dh.get("a", 0.0), dh.get("d", 0.0) + (q if slides else 0.0)
        step = np.array(
            [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1.0]]
        )
        end = ends[made.get("parent", before)] @ step
        ends[made["name"]] = end
        before = made["name"]
        out.append(end)
    return out
