"""Where a leaf is held: its hinges, its lock, the frame's stop, and whether they hold it at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .deformation_part import DeformationPart, Hinge, StopPart
from .leaf_part import Leaf

HINGE_HEIGHTS = (-0.4, 0.0, 0.4)
"""Where hinges sit if the scene does not say: shares of the leaf's height from its centre."""
FLAT = 1e-6
"""Share of the leaf's size by which points must be off one line."""


@dataclass(frozen=True)
class Support:
    """A point that is held both ways through the leaf's plane.

    x, y : from the leaf's centre, m; axes that it can't move along, 0 to 2
    play : m that it may move through the plane either way before it is held
    stiffness : N/m from there on, or None where it is rigid
    """

    name: str
    x: float
    y: float
    axes: tuple[int, ...]
    play: float = 0.0
    stiffness: float | None = None


@dataclass(frozen=True)
class Stop:
    """The frame's stop: its edges, its side (-1 the fire's, +1 the other), its clearance, m."""

    edges: tuple[str, ...]
    side: int
    clearance: float


def _hinges(leaf: Leaf, deformation: DeformationPart) -> list[Hinge]:
    """The hinges from below."""
    given = deformation.hinges
    if given is None:
        given = tuple(Hinge(height=share * leaf.height) for share in HINGE_HEIGHTS)
    return sorted(given, key=lambda hinge: hinge.height)


def _loose(point: Hinge, deformation: DeformationPart, kind: str) -> tuple[float, float | None]:
    play = getattr(deformation, f"{kind}_play") if point.play is None else point.play
    stiffness = point.stiffness or getattr(deformation, f"{kind}_stiffness")
    return float(play), stiffness


def off_the_leaf(leaf: Leaf, deformation: DeformationPart) -> tuple[tuple[str | int, ...], str] | None:
    """The first hinge or lock that is not on the leaf, and the sentence that says so, or None."""
    if deformation.hinge_line >= 0.5 * leaf.width:
        most = 0.5 * leaf.width
        return ("deformation", "hinge_line"), (
            f"is {deformation.hinge_line:g}; give less than half of the leaf's width, {most:g} m"
        )
    for key, points in (("hinges", deformation.hinges or ()), ("lock", deformation.lock)):
        for point in points:
            places = ((point.height, leaf.height), (getattr(point, "across", None) or 0.0, leaf.width))
            for value, size in places:
                if abs(value) > 0.5 * size + 1e-9:
                    return ("deformation", key), (
                        f"has {value:g}, off the leaf; give at most {0.5 * size:g} m from its centre"
                    )
    return None


def symmetric(leaf: Leaf, deformation: DeformationPart) -> bool:
    """Whether the supports of the lower half mirror those of the upper."""
    stop = stop_of(deformation)
    if stop is not None and ("top" in stop.edges) != ("bottom" in stop.edges):
        return False
    points = supports(leaf, deformation)
    hinges = [s for s in points if s.name.startswith("hinge")]
    heights = np.array(sorted(s.y for s in hinges))
    if not np.allclose(heights, -heights[::-1]):
        return False
    locks = [s for s in points if s not in hinges]
    return all(
        any(
            np.isclose(s.y, -o.y) and np.isclose(s.x, o.x) and (s.play, s.stiffness) == (o.play, o.stiffness)
            for o in group
        )
        for group in (hinges, locks)
        for s in group
    )


def supports(leaf: Leaf, deformation: DeformationPart, half: bool = False) -> list[Support]:
    """Hinges and lock, in an order that does not depend on the scene's.

    Every one holds against moving through the plane. Within the plane the hinge nearest to the middle holds
    both ways and the next one across, so that the leaf neither drifts nor turns and still stretches freely.
    Of a half that is mirrored in y, the mirror holds against moving along y and turning: one hinge holds
    across.
    """
    side = -1.0 if deformation.hinge_side == "left" else 1.0
    edge = 0.5 * leaf.width * side
    order = sorted(_hinges(leaf, deformation), key=lambda h: (abs(h.height), h.height))
    kept = [h for h in order if not half or h.height > -1e-12]
    in_plane: tuple[tuple[int, ...], ...] = ((0,),) if half else ((0, 1), (0,))
    found = [
        Support(
            f"hinge at {h.height:g} m",
            edge - side * deformation.hinge_line,
            h.height,
            (*(in_plane[n] if n < len(in_plane) else ()), 2),
            *_loose(h, deformation, "hinge"),
        )
        for n, h in enumerate(kept)
    ]
    for lock in sorted(deformation.lock, key=lambda p: (p.height, p.across or 0.0)):
        if half and lock.height < -1e-12:
            continue
        across = "" if lock.across is None else f" and {lock.across:g} m across"
        found.append(
            Support(
                f"lock at {lock.height:g} m{across}",
                -edge if lock.across is None else lock.across,
                lock.height,
                (2,),
                *_loose(lock, deformation, "lock"),
            )
        )
    return found


def stop_of(deformation: DeformationPart) -> Stop | None:
    """The frame's stop, on the side that the leaf does not open to."""
    if deformation.opens is None:
        return None
    part = deformation.stop or StopPart()
    hinge = deformation.hinge_side
    names = {"hinge": hinge, "latch": "right" if hinge == "left" else "left"}
    side = -1 if deformation.opens == "away_from_fire" else 1
    return Stop(tuple(names.get(edge, edge) for edge in part.edges), side, part.clearance)


def mechanism(leaf: Leaf, deformation: DeformationPart, held: list[Support] | None = None) -> str:
    """What motion the supports, or the places at which a mesh has them, leave free, or nothing.

    The frame's stop does not count: it holds one way, and nothing presses the leaf against it.
    """
    held = supports(leaf, deformation) if held is None else held
    size = max(leaf.width, leaf.height)
    plane = np.array([[1.0, s.x / size, s.y / size] for s in held])
    if np.linalg.matrix_rank(plane, tol=FLAT) == 3:
        return ""
    names = " and ".join(s.name for s in held)
    about = "it" if len(held) == 1 else "the line through them"
    stop = "; the frame's stop holds one way only" if deformation.opens is not None else ""
    return (
        f"is held against moving through its plane by {names}, and is free to turn about {about}{stop}:"
        " a mechanism has no shape; give three points that are not on one line, such as two hinges and a lock"
    )
