"""What a simulator simulates, by name, and which of it a filter means."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from simulation_interfaces.msg import Bounds, EntityCategory, EntityFilters, TagsFilter

from .extended_regex import ExtendedRegex


@dataclass(frozen=True)
class Entity:
    """One of a simulator's things.

    Attributes
    ----------
    category : a constant of simulation_interfaces/EntityCategory
    """

    name: str
    category: int
    description: str
    tags: tuple[str, ...] = ()


class FilterRefused(ValueError):
    """A filter that can't be: what is wrong, and what would be right."""


def selected(entities: Iterable[Entity], filters: EntityFilters) -> list[Entity]:
    """Entities whose whole name matches and that have one of the categories and the tags.

    Raises
    ------
    FilterRefused
        for bounds, which these simulators know nothing of, and for what is no filter
    ValueError
        RegexError for an expression that is none
    """
    if filters.bounds.type != Bounds.TYPE_EMPTY or filters.bounds.points:
        raise FilterRefused("bounds are not supported; leave them empty")
    mode = filters.tags.filter_mode
    if mode not in (TagsFilter.FILTER_MODE_ANY, TagsFilter.FILTER_MODE_ALL):
        raise FilterRefused(f"filter_mode is {mode}; give 0 (any) or 1 (all)")
    expression = ExtendedRegex(filters.filter) if filters.filter else None
    categories = {c.category for c in filters.categories}
    wanted = set(filters.tags.tags)
    every = mode == TagsFilter.FILTER_MODE_ALL
    return [
        e
        for e in entities
        if (expression is None or expression.matches(e.name))
        and (not categories or e.category in categories)
        and (not wanted or (wanted <= set(e.tags) if every else wanted & set(e.tags)))
    ]


def quaternion(turn: Iterable[Iterable[float]]) -> tuple[float, float, float, float]:
    """(x, y, z, w) of a rotation matrix (3, 3), w >= 0 (Shepperd's method)."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    trace = a + e + i
    largest = max(range(4), key=lambda k: (a, e, i, trace)[k])
    if largest == 3:
        s = 0.5 / math.sqrt(1.0 + trace)
        x, y, z, w = (h - f) * s, (c - g) * s, (d - b) * s, 0.25 / s
    elif largest == 0:
        s = 2.0 * math.sqrt(1.0 + a - e - i)
        x, y, z, w = 0.25 * s, (b + d) / s, (c + g) / s, (h - f) / s
    elif largest == 1:
        s = 2.0 * math.sqrt(1.0 + e - a - i)
        x, y, z, w = (b + d) / s, 0.25 * s, (f + h) / s, (c - g) / s
    else:
        s = 2.0 * math.sqrt(1.0 + i - a - e)
        x, y, z, w = (c + g) / s, (f + h) / s, 0.25 * s, (d - b) / s
    sign = 1.0 if w >= 0.0 else -1.0
    return sign * x, sign * y, sign * z, sign * w


ROBOT, STATIC_OBJECT = EntityCategory.CATEGORY_ROBOT, EntityCategory.CATEGORY_STATIC_OBJECT
