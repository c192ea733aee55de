"""Whether masses determine the motion of an imported robot: its mass matrix, rigid, by Jacobians."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexsim_node.rotations.roll_pitch_yaw import rotation

from .account import IN_DOUBT, Account
from .additions import beam_body, body_of
from .bodies import moved
from .urdf import Body, about_axis
from .xml_file import ImportRefused

LEAST = 1e-12  # kg m2 or kg: less than this, a joint moves nothing
SINGULAR = 1e-12  # of the mass matrix with a diagonal of ones
INVOLVED = 0.1  # share of a joint in a motion without mass


def check_determined(scene: Mapping[str, Any], where: Mapping[str, str], account: Account) -> None:
    """Refuse joints that move no mass, alone or together; say where that is so only at the start.

    scene : the document of a scene that was checked
    where : places in the URDF of its joints

    Raises
    ------
    ImportRefused
    """
    names = [link["joint"]["name"] for link in scene["links"] if link["joint"]["type"] != "fixed"]
    given = scene.get("initial", {}).get("position", {})
    start = np.array([float(given.get(name, 0.0)) for name in names] if isinstance(given, dict) else given)
    if start.shape != (len(names),):
        return  # of the actuated ones alone: where the others start is not known
    elsewhere = start + 0.4 * np.sin(1.0 + np.arange(len(names)))  # no pose that anything is straight in
    matrix = mass_matrix(scene["links"], elsewhere)
    idle = [name for name, own in zip(names, np.diag(matrix), strict=True) if own < LEAST]
    together = [] if idle else massless(names, matrix)
    if idle or together:
        hold = " ".join(f"--hold {name}" for name in idle) or f"--hold {together[-1]}"
        what = "joints that move" if idle else "joints that together can move"
        raise ImportRefused(
            f"{where[(idle or together)[0]]}: {what} links without mass or inertia, so that their motion is"
            f" not determined: {', '.join(idle or together)}; give the links an inertial, or hold the joints:"
            f" {hold}"
        )
    at_start = massless(names, mass_matrix(scene["links"], start))
    account.of_several(
        IN_DOUBT, at_start, "move nothing together where the robot starts: give another initial position"
    )


def massless(names: list[str], matrix: np.ndarray) -> list[str]:
    """The joints in a motion that moves no mass, or none."""
    own = np.sqrt(np.maximum(np.diag(matrix), LEAST))
    values, motions = np.linalg.eigh(matrix / np.outer(own, own))
    if values[0] > SINGULAR:
        return []
    return [name for name, part in zip(names, motions[:, 0], strict=True) if abs(part) > INVOLVED]


def mass_matrix(links: list[dict[str, Any]], position: np.ndarray) -> np.ndarray:
    """(m, m) mass matrix of the links at the joints' positions (m,), rotors left out."""
    m = len(position)
    rates: list[np.ndarray] = [np.zeros((0, m))]  # of all bodies, linear and angular
    momenta: list[np.ndarray] = [np.zeros((0, m))]
    poses: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = {
        "base": (np.zeros(3), np.eye(3), np.zeros((6, m)))
    }
    known = {link["name"]: link for link in links}
    k = 0
    for link in links:
        place, turn, twist = poses[link["parent"]]
        offset = np.array(link["frame"].get("xyz", np.zeros(3)), dtype=float)
        if "attach" in link:
            offset = offset + point(known[link["parent"]], link["attach"])
        place = place + turn @ offset
        turn, twist = turn @ rotation(np.array(link["frame"].get("rpy", np.zeros(3)))), twist.copy()
        if link["joint"]["type"] != "fixed":
            axis = np.array(link["joint"]["axis"], dtype=float)
            axis /= np.linalg.norm(axis)
            if link["joint"]["type"] == "prismatic":
                twist[:3, k] = turn @ axis
                place = place + turn @ axis * position[k]
            else:
                twist[:3, k], twist[3:, k] = np.cross(place, turn @ axis), turn @ axis
                turn = turn @ about_axis(axis, position[k])
            k += 1
        poses[link["name"]] = place, turn, twist
        for body in bodies(link):
            body = moved(body, place, turn)
            speed = twist[:3] + np.cross(twist[3:], body.center, axis=0)
            rates += [speed, twist[3:]]
            momenta += [body.mass * speed, body.inertia @ twist[3:]]
    return np.asarray(np.concatenate(rates).T @ np.concatenate(momenta))


def point(link: Mapping[str, Any], name: str) -> np.ndarray:
    """(3,) a link's end or named point, in its frame."""
    found = link.get("end") if name == "end" else link.get("points", {}).get(name)
    return np.array(found or (0.0, 0.0, 0.0), dtype=float)


def bodies(link: Mapping[str, Any]) -> list[Body]:
    """The bodies that a link is made of, in its frame."""
    end = point(link, "end")
    found = [body_of(link["rigid"])] if "rigid" in link else []
    if "payload" in link:
        found.append(moved(body_of(link["payload"]), end, np.eye(3)))
    beam = beam_body(link["beam"], end) if "beam" in link else None
    return found + ([] if beam is None else [beam])
