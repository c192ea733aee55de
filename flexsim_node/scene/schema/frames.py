"""Links placed by frames, led back to links that hang on each other's ends.

The equations know links that begin where another ends.  So a named point, and a joint elsewhere than at the
parent's end, become a rigid massless link of their own, fixed to that end: LINK/POINT and LINK/start.  A link
that takes its end where the first one hangs on it needs none: a serial robot has as many links as by
Denavit-Hartenberg.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from .link import Frame, Joint, Link
from .loop import BASE

Triple = tuple[float, ...]
ORIGIN: Triple = (0.0, 0.0, 0.0)
NEAR = 1e-12  # m; closer places are one


def placed(links: Sequence[Link]) -> bool:
    """Whether each link begins at its parent's end, as the equations need it."""
    return not any(
        link.attach or link.points or (link.frame is not None and (link.end is None or any(link.frame.xyz)))
        for link in links
    )


def start_of(link: Link, parent: Link | None) -> Triple:
    """Where a link of `frame` begins: (3,) in the parent's frame, m."""
    assert link.frame is not None
    at = ORIGIN
    if parent is not None and link.attach:
        at = (parent.end or ORIGIN) if link.attach == "end" else parent.points[link.attach]
    return tuple(a + b for a, b in zip(at, link.frame.xyz, strict=True))


def at_ends(links: Sequence[Link], parents: Sequence[int]) -> list[tuple[int, Link]]:
    """The links with their points and offsets as links of their own, each at the end of its parent.

    Each comes with the number of the link to which it belongs.
    """
    ends = [_end(n, links, parents) for n in range(len(links))]
    found: list[tuple[int, Link]] = []
    for n, (link, parent) in enumerate(zip(links, parents, strict=True)):
        name, offset = _hangs_on(link, links[parent] if parent >= 0 else None, ends[parent])
        if math.hypot(*offset) > NEAR:
            found.append((n, _rod(f"{link.name}/start", name, offset)))
            name = found[-1][1].name
        update: dict[str, Any] = {"parent": name, "attach": "", "points": {}}
        if link.frame is not None:
            update |= {"frame": Frame(rpy=link.frame.rpy), "end": ends[n]}
        found.append((n, link.model_copy(update=update)))
        for point, place in link.points.items():
            found.append((n, _rod(f"{link.name}/{point}", link.name, _less(place, ends[n]))))
    return found


def _hangs_on(link: Link, above: Link | None, end: Triple) -> tuple[str, Triple]:
    """Name of the link on whose end a link hangs, and how far from there it begins, m."""
    if above is None:
        return BASE, link.frame.xyz if link.frame is not None else ORIGIN
    own_point = link.attach not in ("", "end")
    if link.frame is None or (own_point and not any(link.frame.xyz)):
        return (f"{above.name}/{link.attach}" if own_point else above.name), ORIGIN
    if link.attach == "end":
        return above.name, link.frame.xyz
    return above.name, _less(start_of(link, above), end if above.frame is not None else ORIGIN)


def _less(a: Triple, b: Triple) -> Triple:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _end(n: int, links: Sequence[Link], parents: Sequence[int]) -> Triple:
    """A link's end in its frame: as given, else where the first link hangs on it."""
    link = links[n]
    if link.frame is None or link.end is not None:
        return link.end or ORIGIN
    for child, parent in zip(links, parents, strict=True):
        if parent == n and child.frame is not None and child.attach != "end":
            return start_of(child, link)
    return ORIGIN


def _rod(name: str, parent: str, end: Triple) -> Link:
    """A rigid massless link of the parent's axes."""
    return Link(name=name, parent=parent, frame=Frame(), end=end, joint=Joint(type="fixed"))
