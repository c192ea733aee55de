"""What varies: values of one key of the scene, as a function of a share between 0 and 1."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

RIGHT = (
    "give a list of values, {from: 1, to: 2, count: 5} with spacing: log if wanted, or a distribution:"
    " {normal: [mean, deviation]}, {lognormal: [median, factor]}, {uniform: [least, most]}, with"
    " within: [least, most] where it ends"
)
DISTRIBUTIONS = ("normal", "lognormal", "uniform")
MOST_LEVELS = 100_000
TINY = 2.0**-53


class InputError(ValueError):
    """A key's variation that can't be meant: what is wrong, what would be right."""


@dataclass(frozen=True)
class Input:
    """One key that varies.

    values : a list's; else `kind` is a range ("linear", "log") or a distribution, with two numbers `of`
    count : how many levels a range has in a grid, or None
    within : where a distribution ends
    scale : whether the value multiplies what the scene has there, tables also
    """

    key: str
    kind: str
    values: tuple[Any, ...] = ()
    of: tuple[float, float] = (0.0, 1.0)
    count: int | None = None
    within: tuple[float, float] = (-math.inf, math.inf)
    scale: bool = False

    @property
    def random(self) -> bool:
        """Whether it is a distribution: uncertain, not chosen."""
        return self.kind in DISTRIBUTIONS

    @property
    def continuous(self) -> bool:
        """Whether it takes any value between two."""
        return self.kind != "list"

    @property
    def levels(self) -> tuple[Any, ...] | None:
        """Values in a grid; None where it has none."""
        if self.kind == "list":
            return self.values
        if self.count is None:
            return None
        shares = np.linspace(0.0, 1.0, self.count) if self.count > 1 else np.array([0.0])
        return tuple(self.at(float(u)) for u in shares)

    def at(self, share: float) -> Any:
        """Return the value below which a share of all values lies."""
        from scipy.special import ndtr, ndtri

        first, second = self.of
        if self.kind == "list":
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        if self.kind in ("linear", "uniform"):
            # Both ends are met to the bit.
            return second if share == 1.0 else first + share * (second - first)
        if self.kind == "log":
            return second if share == 1.0 else first if share == 0.0 else first * (second / first) ** share
        # A sample may draw the end of the unit interval, where a normal value is infinite.
        share = min(max(share, TINY), 1.0 - TINY)
        low, high = self.within
        log = self.kind == "lognormal"
        if log:
            first, second = math.log(first), math.log(second)
            low, high = (math.log(v) if v > 0.0 else -math.inf for v in (low, high))
        least, most = ndtr((low - first) / second), ndtr((high - first) / second)
        found = first + second * float(ndtri(least + share * (most - least)))
        found = min(max(found, low), high)
        return math.exp(found) if log else found


def read_input(key: str, given: Any) -> Input:
    """Read how a key varies.

    Raises
    ------
    InputError
    """
    if isinstance(given, Mapping) and "scale" in given:
        if len(given) > 1:
            raise InputError(
                f"scale stands beside {', '.join(map(str, given))}; give {{scale: {{...}}}} alone"
            )
        inner = read_input(key, given["scale"])
        numbers = inner.values if inner.kind == "list" else ()
        if not all(_is_number(v) for v in numbers):
            raise InputError("scale takes numbers; give factors such as {scale: {normal: [1, 0.15]}}")
        return Input(key, inner.kind, inner.values, inner.of, inner.count, inner.within, scale=True)
    if isinstance(given, (list, tuple)):
        if not given:
            raise InputError(f"is an empty list; {RIGHT}")
        return Input(key, "list", tuple(given))
    if not isinstance(given, Mapping):
        raise InputError(f"is {given!r}; {RIGHT}")
    if "from" in given or "to" in given:
        return _range(key, given)
    kinds = [k for k in given if k in DISTRIBUTIONS]
    if len(kinds) != 1:
        raise InputError(f"is a set of keys {', '.join(map(str, given))}; {RIGHT}")
    kind = kinds[0]
    _only(given, (kind, "within"))
    first, second = of = _pair(given[kind], kind)
    if kind == "normal" and not second > 0.0:
        raise InputError(f"normal: the deviation is {second:g}; give more than 0")
    if kind == "lognormal" and not (first > 0.0 and second > 1.0):
        raise InputError(f"lognormal: [{first:g}, {second:g}]; give a median above 0 and a factor above 1")
    if kind == "uniform":
        _rising(of, "uniform")
        if "within" in given:
            raise InputError("uniform has its ends already; leave out within")
        return Input(key, kind, of=of)
    within = _pair(given["within"], "within") if "within" in given else (-math.inf, math.inf)
    _rising(within, "within")
    made = Input(key, kind, of=of, within=within)
    # A part of the tail in which the normal function has no digits left gives no values.
    if not (math.isfinite(made.at(0.5)) and within[0] < made.at(0.5) < within[1]):
        raise InputError(
            f"within: [{within[0]:g}, {within[1]:g}] has next to none of the distribution; widen it"
        )
    return made


def _range(key: str, given: Mapping[str, Any]) -> Input:
    _only(given, ("from", "to", "count", "spacing"))
    if "from" not in given or "to" not in given:
        raise InputError(f"has only one of from and to; {RIGHT}")
    of = _pair([given["from"], given["to"]], "from, to")
    _rising(of, "from, to")
    spacing = given.get("spacing", "linear")
    if spacing not in ("linear", "log"):
        raise InputError(f"spacing is {spacing!r}; give linear or log")
    if spacing == "log" and not of[0] > 0.0:
        raise InputError(f"spacing is log from {of[0]:g}; give a from above 0")
    count = given.get("count")
    if count is not None and (type(count) is not int or not 1 <= count <= MOST_LEVELS):
        raise InputError(f"count is {count!r}; give a whole number from 1 to {MOST_LEVELS}")
    return Input(key, spacing, of=of, count=count)


def _only(given: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for key in given:
        if key not in known:
            raise InputError(f"{key!r} is not known beside {known[0]}; known are {', '.join(known)}")


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _pair(value: Any, name: str) -> tuple[float, float]:
    if not (isinstance(value, (list, tuple)) and len(value) == 2 and all(map(_is_number, value))):
        raise InputError(f"{name} is {value!r}; give two numbers")
    return float(value[0]), float(value[1])


def _rising(pair: tuple[float, float], name: str) -> None:
    if not pair[0] < pair[1]:
        raise InputError(f"{name}: {pair[0]:g} is not below {pair[1]:g}; give the lesser one first")
