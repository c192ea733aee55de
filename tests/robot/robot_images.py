"""The same robot described another way: turned, mirrored, a link in two pieces."""

from __future__ import annotations

import copy

import numpy as np
from random_robots import Scene

MIRROR = np.diag([1.0, -1.0, 1.0])


def rotation(theta: float, alpha: float) -> np.ndarray:
    """(3, 3) of a frame set off by Denavit-Hartenberg angles."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0.0, sa, ca]])


def turned(scene: Scene, theta: float, alpha: float) -> Scene:
    """The robot on a bracket that turns it, gravity turned with it."""
    scene = copy.deepcopy(scene)
    bracket = {"name": "bracket", "parent": "base", "dh": {"theta": theta, "alpha": alpha}}
    scene["links"][0].setdefault("parent", "base")
    for made in scene["links"]:
        if made.get("parent") == "base":
            made["parent"] = "bracket"
    scene["links"].insert(0, {**bracket, "joint": {"type": "fixed"}})
    scene["gravity"] = (rotation(theta, alpha) @ scene["gravity"]).tolist()
    return scene


def mirrored(scene: Scene) -> Scene:
    """The robot in a mirror whose normal is the base's y axis: angles change their signs, slides don't."""
    scene = copy.deepcopy(scene)
    for made in scene["links"]:
        for key in ("theta", "alpha"):
            made["dh"][key] = -made["dh"].get(key, 0.0)
        for name in ("rigid", "payload"):
            if name in made:
                made[name]["center_of_mass"] = (MIRROR @ made[name]["center_of_mass"]).tolist()
                made[name]["inertia"] = (MIRROR @ made[name]["inertia"] @ MIRROR).tolist()
    scene["gravity"] = (MIRROR @ scene["gravity"]).tolist()
    for key in ("position", "velocity"):
        if key in scene["initial"]:
            start = scene["initial"][key]
            scene["initial"][key] = {name: sign * start[name] for name, sign in signs(scene).items()}
    for loop in scene.get("loops", ()):
        for key in ("at", "axis"):
            if key in loop:
                loop[key] = {name: (MIRROR @ v).tolist() for name, v in loop[key].items()}
    return scene


def signs(scene: Scene) -> dict[str, float]:
    """Of every joint's coordinate, what a mirror makes of it."""
    moving = [k["joint"] for k in scene["links"] if k["joint"]["type"] != "fixed"]
    return {k["name"]: -1.0 if k["type"] == "revolute" else 1.0 for k in moving}


def straightened(scene: Scene) -> Scene:
    """Every beam's twist alpha moved into a frame without length behind it, so that the beam can be cut."""
    scene = copy.deepcopy(scene)
    links, renamed, before = [], {"base": "base"}, "base"
    for made in scene["links"]:
        parent = renamed[made.get("parent", before)]
        before = made["name"]
        made["parent"] = parent
        links.append(made)
        renamed[before] = before
        alpha = made["dh"].pop("alpha", 0.0)
        if "beam" in made and alpha:
            frame = {
                "name": f"{before}_turn",
                "parent": before,
                "dh": {"alpha": alpha},
                "joint": {"type": "fixed"},
            }
            if "payload" in made:
                frame["payload"] = made.pop("payload")
            links.append(frame)
            renamed[before] = frame["name"]
        else:
            made["dh"]["alpha"] = alpha
    return {**scene, "links": links}


def cut(scene: Scene) -> Scene:
    """Every beam of a straightened robot in two pieces of as many elements, welded together."""
    scene = copy.deepcopy(scene)
    links, renamed, before = [], {"base": "base"}, "base"
    for made in scene["links"]:
        name = made["name"]
        made["parent"] = renamed[made.get("parent", before)]
        before = renamed[name] = name
        links.append(made)
        if "beam" in made and not made["dh"].get("alpha"):
            dh = made["dh"]
            half = {"a": 0.5 * dh.get("a", 0.0), "d": 0.5 * dh.get("d", 0.0)}
            second = {**copy.deepcopy(made), "name": f"{name}_2", "parent": name, "dh": half}
            second["joint"] = {"type": "fixed"}
            made["dh"] = {**half, "theta": dh.get("theta", 0.0)}
            made.pop("payload", None)
            links.append(second)
            renamed[name] = second["name"]
    return {**scene, "links": links}


def with_twice_the_elements(scene: Scene) -> Scene:
    """What `cut` is to be compared with."""
    scene = copy.deepcopy(scene)
    for made in scene["links"]:
        if "beam" in made:
            made["beam"]["elements"] = 2 * made["beam"].get("elements", 2)
    return scene
