"""What a URDF does not say and a user adds: beams, springs, rotors, loops; keys of a scene put over it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from flexsim_core.scene_files import SceneError, plain, read_scene

from .account import CHANGED, IN_DOUBT, TOOK, Account
from .bodies import SLACK, excess, mended, together, without
from .scene import rigid
from .sections import beam_of
from .urdf import Body
from .xml_file import ImportRefused

NOT_OVER = ("model", "name", "source")


def read_additions(path: Path) -> dict[str, Any]:
    """A file of scene keys: `links` and `joints` by name, all others as a scene has them."""
    try:
        found: dict[str, Any] = plain(read_scene(path, "links, joints, loops"))
    except SceneError as problem:
        raise ImportRefused(str(problem)) from None
    for key in ("links", "joints"):
        if not isinstance(found.get(key, {}), dict):
            raise ImportRefused(f"{path}: {key}: is no mapping; give names and below them their keys")
    for key in NOT_OVER:
        if key in found:
            raise ImportRefused(f"{path}: {key}: comes from the robot's description; leave it out")
    return found


def add(scene: dict[str, Any], given: Mapping[str, Any], beams: Mapping[str, str], account: Account) -> None:
    """Put additions and beams in words over an imported scene.

    Raises
    ------
    ImportRefused
        where a link or joint is unknown
    """
    links = {link["name"]: link for link in scene["links"]}
    joints = {link["joint"]["name"]: link["joint"] for link in scene["links"] if "name" in link["joint"]}
    bending: dict[str, dict[str, Any]] = {}
    for name, words in beams.items():
        try:
            bending[name] = {"beam": beam_of(words)}
        except ValueError as problem:
            raise ImportRefused(f"--beam {name}: {problem}") from None
    own_links = given.get("links", {})
    for name in own_links:
        if name in bending and "beam" in (own_links[name] or {}):
            raise ImportRefused(f"--beam {name}: has a beam in --with too; give one of the two")
    for key, named, known in (
        ("links", own_links, links), ("joints", given.get("joints", {}), joints), ("--beam", bending, links),
    ):  # fmt: skip
        for name, keys in named.items():
            if name not in known:
                raise ImportRefused(f"{key}: {name!r} is not there; give one of {', '.join(known)}")
            if not isinstance(keys, dict):
                raise ImportRefused(f"{key}: {name}: is {keys!r}; give keys such as a scene has them")
            merge(known[name], keys)
            what = "bends" if "beam" in keys else f"has its own {', '.join(keys)}"
            account.say(TOOK, name, what)
    for name, link in links.items():
        if "beam" in link:
            give_end(name, link, scene["links"])
            if "rigid" in link:
                share_mass(name, link, account)
            tell_arms(name, link, scene["links"], account)
    for key, value in given.items():
        if key not in ("links", "joints"):
            merge(scene, {key: value})
            account.say(TOOK, key, "as added")


def merge(into: dict[str, Any], keys: Mapping[str, Any]) -> None:
    """Put keys over those of a document, mappings key by key."""
    for key, value in keys.items():
        if isinstance(value, Mapping) and isinstance(into.get(key), dict):
            merge(into[key], value)
        else:
            into[key] = value


def give_end(name: str, link: dict[str, Any], links: list[dict[str, Any]]) -> None:
    """Where a link that bends ends, if not given: where the first link hangs on it, or its first point."""
    if "end" in link:
        return
    child = next((k for k in links if k["parent"] == name and "attach" not in k), None)
    points = list(link.get("points", {}).values())
    if child is None and not points:
        raise ImportRefused(
            f"{name}: nothing hangs on it, so that its beam has no end; give it in --with:"
            f" links: {{{name}: {{end: [x, y, z]}}}}"
        )
    link["end"] = child["frame"]["xyz"] if child is not None else points[0]


def tell_arms(name: str, link: Mapping[str, Any], links: list[dict[str, Any]], account: Account) -> None:
    """Say what does not hang on the beam's end itself, but on a rigid arm there."""
    end = np.array(link["end"], dtype=float)
    hanging = {k["name"]: k["frame"]["xyz"] for k in links if k["parent"] == name and "attach" not in k}
    for other, place in (link.get("points", {}) | hanging).items():
        off = float(np.linalg.norm(np.array(place, dtype=float) - end))
        if off > 1e-9:
            account.say(IN_DOUBT, other, f"is {off:.4g} m from the end of the beam of {name}, on a rigid arm")


def share_mass(name: str, link: dict[str, Any], account: Account) -> None:
    """The URDF's body of a link that bends: less the beam, it rides on the link's end."""
    beam, end = link["beam"], np.array(link["end"], dtype=float)
    own = beam_body(beam, end)
    if own is None:
        return  # the scene's own check says what is wrong with it
    whole = body_of(link.pop("rigid"))
    left = without(whole, own)
    if left is None:
        what = (
            f"has the mass of its beam, {own.mass:.4g} kg, for the URDF's {whole.mass:.4g} kg, which is less"
        )
        account.say(CHANGED, name, what)
        return
    kept = "mass, centre and inertia together are the URDF's"
    if excess(left.inertia) > SLACK:
        left = Body(left.mass, left.center, mended(left.inertia))
        now = np.linalg.eigvalsh(together([left, own]).inertia)  # type: ignore[union-attr]
        was, moments = (
            ", ".join(f"{x:.4g}" for x in found) for found in (np.linalg.eigvalsh(whole.inertia), now)
        )
        kept = f"mass and centre together are the URDF's; principal moments go from {was} to {moments} kg m2"
    rides = [Body(left.mass, left.center - end, left.inertia)]
    if "payload" in link:  # what was added rides there too
        rides.append(body_of(link["payload"]))
    both = together(rides)
    assert both is not None
    link["payload"] = rigid(both)
    shares = f"of its {whole.mass:.4g} kg the beam has {own.mass:.4g}; the rest, {left.mass:.4g} kg,"
    account.say(CHANGED, name, f"{shares} rides on its end ({kept})")
    if np.linalg.norm(left.center) > 0.75 * np.linalg.norm(end):
        account.say(IN_DOUBT, name, "the rest's centre of mass is nearer to the beam's start than to its end")


def body_of(keys: Mapping[str, Any]) -> Body:
    """A rigid body or payload of a scene."""
    center = np.array(keys.get("center_of_mass", (0.0, 0.0, 0.0)), dtype=float)
    inertia = np.array(keys.get("inertia") or np.zeros((3, 3)), dtype=float)
    return Body(float(keys.get("mass", 0.0)), center, inertia)


def beam_body(beam: Mapping[str, Any], end: np.ndarray) -> Body | None:
    """A straight beam from the origin to an end as a rigid body, or None where its keys are not complete."""
    length = float(np.linalg.norm(end))
    try:
        if "width" in beam:
            w, d = float(beam["width"]), float(beam["depth"])
            area, iy, iz = w * d, w * d**3 / 12.0, d * w**3 / 12.0
        else:
            area, iy, iz = (float(beam[key]) for key in ("area", "iy", "iz"))
        line = float(beam["density"])
    except (KeyError, TypeError, ValueError):
        return None
    if not (length > 0.0 and line > 0.0 and area > 0.0):
        return None
    x = end / length
    z = np.array([0.0, 0.0, 1.0]) - x[2] * x
    if np.linalg.norm(z) < 1e-9:
        z = np.array([1.0, 0.0, 0.0]) - x[0] * x
    z /= np.linalg.norm(z)
    axes = np.column_stack([x, np.cross(z, x), z])
    mass, across = line * area * length, line * area * length**3 / 12.0
    own = np.diag([line * length * (iy + iz), across + line * length * iy, across + line * length * iz])
    return Body(mass, 0.5 * end, axes @ own @ axes.T)
