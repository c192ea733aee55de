"""Where a leaf is held: its hinges and its lock, and whether they hold it at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .parts import DeformationPart, Leaf

HINGE_HEIGHTS = (-0.4, 0.0, 0.4)
"""Where hinges sit if the scene does not say: shares of the leaf's height from its centre."""
FLAT = 1e-6
"""Share of the leaf's size by which points must be off one line."""


@dataclass(frozen=True)
class Support:
    """A point that is held: x, y from the leaf's centre, m; axes that it can't move along, 0 to 2."""

    name: str
    x: float
    y: float
    axes: tuple[int, ...]


def hinge_heights(leaf: Leaf, deformation: DeformationPart) -> tuple[float, ...]:
    """Heights of the hinges, m from the centre, from below, each once."""
    given = deformation.hinges
    if given is None:
        given = tuple(share * leaf.height for share in HINGE_HEIGHTS)
    return tuple(sorted(set(given)))


def symmetric(leaf: Leaf, deformation: DeformationPart) -> bool:
    """Whether the supports of the lower half mirror those of the upper."""
    heights = np.array(hinge_heights(leaf, deformation))
    return bool(np.allclose(heights, -heights[::-1])) and deformation.lock in (0.0, None)


def supports(leaf: Leaf, deformation: DeformationPart, half: bool = False) -> list[Support]:
    """Hinges and lock, in an order that does not depend on the scene's.

    Every one holds against moving through the plane. Within the plane the hinge nearest to the middle holds
    both ways and the next one across, so that the leaf neither drifts nor turns and still stretches freely.
    Of a half that is mirrored in y, the mirror holds against moving along y and turning: one hinge holds
    across.
    """
    side = -1.0 if deformation.hinge_side == "left" else 1.0
    x = 0.5 * leaf.width * side
    order = sorted(hinge_heights(leaf, deformation), key=lambda y: (abs(y), y))
    kept = [y for y in order if not half or y > -1e-12]
    in_plane: tuple[tuple[int, ...], ...] = ((0,),) if half else ((0, 1), (0,))
    found = [
        Support(f"hinge at {y:g} m", x, y, (*(in_plane[n] if n < len(in_plane) else ()), 2))
        for n, y in enumerate(kept)
    ]
    lock = deformation.lock
    if lock is not None:
        found.append(Support(f"lock at {lock:g} m", -x, lock, (2,)))
    return found


def mechanism(leaf: Leaf, deformation: DeformationPart, held: list[Support] | None = None) -> str:
    """What motion the supports, or the places at which a mesh has them, leave free, or nothing."""
    held = supports(leaf, deformation) if held is None else held
    size = max(leaf.width, leaf.height)
    plane = np.array([[1.0, s.x / size, s.y / size] for s in held])
    if np.linalg.matrix_rank(plane, tol=FLAT) == 3:
        return ""
    names = " and ".join(s.name for s in held)
    about = "it" if len(held) == 1 else "the line through them"
    return (
        f"is held against moving through its plane by {names}, and is free to turn about {about}: a mechanism"
        " has no shape; give three points that are not on one line, such as two hinges and a lock"
    )
