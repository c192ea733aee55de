"""Rigid bodies: put together exactly, and held against what a body can be."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .urdf import NOTHING, Body

ROUNDED = 0.01  # of the largest moment: what rounding in a file may have done to the others
SLACK = 1e-9  # as scenes allow
HEAVY, FAR, THIN = 1000.0, 3.0, 1e-4  # kg; m; m: beyond these a unit is in doubt


def moved(body: Body, place: np.ndarray, turn: np.ndarray) -> Body:
    """The body in other axes, of which its own lie at place (3,), turned by turn (3, 3)."""
    return Body(body.mass, place + turn @ body.center, turn @ body.inertia @ turn.T)


def about(body: Body, point: np.ndarray) -> np.ndarray:
    """(3, 3) inertia about a point (parallel axes), kg m2."""
    r = body.center - point
    return body.inertia + body.mass * (r @ r * np.eye(3) - np.outer(r, r))


def together(bodies: Iterable[Body]) -> Body | None:
    """One body of several in the same axes, or None where there is no mass."""
    parts = list(bodies)
    mass = sum(part.mass for part in parts)
    if mass <= 0.0:
        return None
    if len(parts) == 1:
        return parts[0]
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / mass
    inertia = sum((about(part, center) for part in parts), np.zeros((3, 3)))
    return Body(mass, center, 0.5 * (inertia + inertia.T))


def without(body: Body, part: Body) -> Body | None:
    """What is left of a body without a part of it, or None where the part has all its mass or more."""
    mass = body.mass - part.mass
    if mass <= 1e-9 * body.mass:
        return None
    center = (body.mass * body.center - part.mass * part.center) / mass
    inertia = about(body, center) - about(part, center)
    return Body(mass, center, 0.5 * (inertia + inertia.T))


def excess(inertia: np.ndarray) -> float:
    """By what share of its largest moment an inertia misses being one of a body; 0 where it is one."""
    moments = np.linalg.eigvalsh(inertia)
    scale = float(np.max(np.abs(moments)))
    if scale < NOTHING:
        return 0.0
    return max(0.0, -float(moments[0]), float(moments[2] - moments[1] - moments[0])) / scale


def mended(inertia: np.ndarray) -> np.ndarray:
    """The nearest inertia that a body can have: no negative moment, the largest at most the others' sum."""
    moments, axes = np.linalg.eigh(inertia)
    moments = np.maximum(moments, 0.0)
    moments[2] = min(moments[2], moments[0] + moments[1])
    found = axes @ np.diag(moments) @ axes.T
    return np.asarray(0.5 * (found + found.T))


def doubts(body: Body) -> list[str]:
    """What is possible, but is seldom meant."""
    found = []
    if body.mass == 0.0:
        return ["has an inertia without a mass"]
    radius = float(np.sqrt(np.max(np.linalg.eigvalsh(body.inertia)).clip(0.0) / body.mass))
    if body.mass > HEAVY:
        found.append(f"weighs {body.mass:g} kg; is it in grams?")
    if radius > FAR:
        found.append(f"its inertia is that of a body {2 * radius:.3g} m wide; is it in kg mm2?")
    if 0.0 < radius < THIN:
        found.append(f"its inertia is that of a body {2e3 * radius:.2g} mm wide, of {body.mass:g} kg")
    if radius == 0.0:
        found.append("has a mass but no inertia: a point mass")
    if np.linalg.norm(body.center) > FAR:
        found.append(f"has its centre of mass {np.linalg.norm(body.center):.3g} m off; is it in mm?")
    if np.array_equal(body.inertia, np.eye(3)):
        found.append("has the inertia 1, 1, 1 kg m2, which looks like a placeholder")
    return found
