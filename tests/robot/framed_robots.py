"""Robots of Denavit-Hartenberg parameters written by frames."""

from __future__ import annotations

import copy

import numpy as np
import pinocchio


def about(axis: int, angle: float) -> np.ndarray:
    """(3, 3) rotation about x (0), y (1) or z (2)."""
    c, s = np.cos(angle), np.sin(angle)
    turn, (i, k) = np.eye(3), ((axis + 1) % 3, (axis + 2) % 3)
    turn[i, i] = turn[k, k] = c
    turn[i, k], turn[k, i] = -s, s
    return turn


def angles(turn: np.ndarray) -> list[float]:
    """Roll, pitch and yaw of Rz(yaw) Ry(pitch) Rx(roll)."""
    return list(pinocchio.rpy.matrixToRpy(turn))


def by_frames(made: dict) -> dict:
    """A robot of Denavit-Hartenberg parameters by frames; the link frames have the same directions."""
    found = copy.deepcopy(made)
    ends: dict[str, np.ndarray] = {}
    before = "base"
    for n, link in enumerate(found["links"]):
        dh = {"a": 0.0, "d": 0.0, "alpha": 0.0, "theta": 0.0} | link.pop("dh", {})
        back = about(0, dh["alpha"])
        end = back.T @ [dh["a"], 0.0, dh["d"]]
        parent = link.get("parent", before)
        link["frame"] = {"rpy": angles(about(2, dh["theta"]) @ back)}
        if parent in ends and n % 2:
            link["attach"] = "end"  # the other way to say it
        elif parent in ends:
            link["frame"]["xyz"] = ends[parent].tolist()
        link["end"] = end.tolist()
        if link["joint"]["type"] != "fixed" and dh["alpha"] != 0.0:
            link["joint"]["axis"] = (3.0 * back.T[:, 2]).tolist()
        if "rigid" in link:  # counts from the joint
            link["rigid"]["center_of_mass"] = (np.array(link["rigid"]["center_of_mass"]) + end).tolist()
        ends[link["name"]], before = end, link["name"]
    return found
