"""Expressions over what a run gave, in a grammar of their own.

They are read by Python's parser and never run by it: a node that is not named here is refused. Numbers are
floats; a quantity over time is a `Series`.

    max(unexposed_mean) - 20
    held('insulation') >= 60 and failure_time('gap anywhere') > 1800
    settling_time(position('joint_1'), 1e-3)
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

LONGEST, DEEPEST = 1000, 30
WRONG = "give a sum, comparison or function of a run's outputs, such as max(unexposed_mean) < 160"


class ExpressionError(ValueError):
    """An expression that can't be read, or names what isn't there."""


class Undefined(ArithmeticError):
    """An expression that has no value for this run: why."""


@dataclass(frozen=True)
class Series:
    """A quantity over time: time (K,), s; value (K,)."""

    time: np.ndarray
    value: np.ndarray

    def __post_init__(self) -> None:
        if not len(self.time):
            raise Undefined("the run has no sample")


@dataclass(frozen=True)
class Absent:
    """A quantity that the scene does not give, and why: naming it is a mistake of the study's."""

    why: str


Value = float | bool | str | Series
Outputs = Mapping[str, Any]
"""Names to values, or to functions of strings and numbers, such as probe('tc_1')."""


class Expression:
    """An expression that was read and found to be within the grammar.

    known : names that a run's outputs will have; text : as it was written

    Raises
    ------
    ExpressionError
        In one sentence: what is not allowed, or not known
    """

    def __init__(self, text: object, known: frozenset[str]) -> None:
        self.text = str(text).lower() if isinstance(text, bool) else str(text)
        if len(self.text) > LONGEST:
            raise ExpressionError(f"an expression of {len(self.text)} characters; give at most {LONGEST}")
        try:
            tree = ast.parse(self.text.strip(), mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise ExpressionError(f"{self.text!r} can't be read; {WRONG}") from None
        self._tree = tree.body
        _check(self._tree, known, self.text, 0)

    def __call__(self, outputs: Outputs) -> float | bool | str:
        """Return the value for a run; raises Undefined, ExpressionError."""
        with np.errstate(all="ignore"):
            found = _plain(_value(self._tree, outputs))
        if isinstance(found, Series):
            raise ExpressionError(
                f"{self.text!r} is a quantity over time; take max, final or at(..., t) of it"
            )
        if isinstance(found, float) and math.isnan(found):
            raise Undefined(f"{self.text!r} is not a number")
        return found

    def excess(self, outputs: Outputs) -> float:
        """Return by how much a condition is broken: 0 where it holds, 1 where that can't be measured."""
        with np.errstate(all="ignore"):
            found = _excess(self._tree, outputs)
        if math.isnan(found):
            raise Undefined(f"{self.text!r} is not a number")
        return found


def _check(node: ast.AST, known: frozenset[str], text: str, depth: int) -> None:
    """Refuse what the grammar does not have."""
    if depth > DEEPEST:
        raise ExpressionError(f"an expression nested more than {DEEPEST} deep; give a simpler one")
    if isinstance(node, ast.Constant):
        if type(node.value) not in (int, float, bool, str):
            raise ExpressionError(f"{text!r}: {node.value!r} is not allowed; give numbers or names in quotes")
        if type(node.value) is int and abs(node.value) > 10**300:
            raise ExpressionError(f"{text!r}: a number beyond 1e300; give a smaller one")
        return
    if isinstance(node, ast.Name):
        if node.id not in known:
            raise ExpressionError(_unknown(node.id, known, text))
        return
    inner: list[ast.AST]
    if isinstance(node, ast.Call):
        if not isinstance(node.func, ast.Name) or node.keywords:
            raise ExpressionError(f"{text!r}: a call of this kind is not allowed; {WRONG}")
        if node.func.id not in FUNCTIONS and node.func.id not in known:
            raise ExpressionError(_unknown(node.func.id, known | set(FUNCTIONS), text))
        least, most = FUNCTIONS[node.func.id][1:] if node.func.id in FUNCTIONS else (0, 2)
        if not least <= len(node.args) <= most:
            count = f"{least}" if least == most else f"{least} to {most}"
            raise ExpressionError(f"{text!r}: {node.func.id} takes {count} values, not {len(node.args)}")
        inner = list(node.args)
    elif isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
        inner = [node.left, node.right]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd, ast.Not)):
        inner = [node.operand]
    elif isinstance(node, ast.BoolOp):
        inner = list(node.values)
    elif isinstance(node, ast.Compare) and all(type(op) in COMPARISONS for op in node.ops):
        inner = [node.left, *node.comparators]
    else:
        kind = type(node.op).__name__ if isinstance(node, ast.BinOp) else type(node).__name__
        raise ExpressionError(f"{text!r}: {kind} is not allowed in an expression; {WRONG}")
    for one in inner:
        _check(one, known, text, depth + 1)


def _unknown(name: str, known: frozenset[str] | set[str], text: str) -> str:
    import difflib

    near = difflib.get_close_matches(name, sorted(known), 1)
    right = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(sorted(known))}"
    return f"{text!r}: {name!r} is not known; {right}"


def _value(node: ast.AST, outputs: Outputs) -> Value:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, (bool, str)) else float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        found = outputs[node.id]
        if isinstance(found, Absent):
            raise ExpressionError(f"{node.id}: {found.why}")
        if callable(found):
            raise ExpressionError(f"{node.id} needs a name in brackets, such as {node.id}('...')")
        return found
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        arguments = [_value(one, outputs) for one in node.args]
        if node.func.id in FUNCTIONS:
            return _plain(FUNCTIONS[node.func.id][0](*arguments))
        function = outputs[node.func.id]
        if not callable(function):
            raise ExpressionError(f"{node.func.id} is a quantity and takes nothing in brackets")
        try:
            return _plain(function(*arguments))
        except TypeError:
            raise ExpressionError(f"{node.func.id} does not take {len(arguments)} such values") from None
    if isinstance(node, ast.BinOp):
        left, right = _value(node.left, outputs), _value(node.right, outputs)
        return _elementwise(ARITHMETIC[type(node.op)], left, right)
    if isinstance(node, ast.UnaryOp):
        operand = _value(node.operand, outputs)
        if isinstance(node.op, ast.Not):
            return not _truth(operand)
        return _elementwise(lambda a, b: b * a, operand, -1.0 if isinstance(node.op, ast.USub) else 1.0)
    if isinstance(node, ast.BoolOp):
        every = isinstance(node.op, ast.And)
        # All are computed, so that a wrong name is found wherever it stands.
        each = [_truth(_value(one, outputs)) for one in node.values]
        return all(each) if every else any(each)
    assert isinstance(node, ast.Compare)
    sides = [_value(one, outputs) for one in (node.left, *node.comparators)]
    return all(_compared(op, a, b) for op, a, b in zip(node.ops, sides, sides[1:], strict=False))


def _excess(node: ast.AST, outputs: Outputs) -> float:
    if isinstance(node, ast.BoolOp):
        each = [_excess(one, outputs) for one in node.values]
        return sum(each) if isinstance(node.op, ast.And) else min(each)
    if isinstance(node, ast.Compare):
        sides = [_value(one, outputs) for one in (node.left, *node.comparators)]
        total = 0.0
        for op, a, b in zip(node.ops, sides, sides[1:], strict=False):
            if _compared(op, a, b):
                continue
            measurable = type(a) is type(b) is float and math.isfinite(a) and math.isfinite(b)
            # Equal sides of a strict comparison do break it.
            total += max(abs(a - b), 1e-300) if measurable else 1.0  # type: ignore[operator]
        return total
    return 0.0 if _truth(_value(node, outputs)) else 1.0


def _compared(op: ast.cmpop, a: Value, b: Value) -> bool:
    if isinstance(a, Series) or isinstance(b, Series):
        raise ExpressionError("a quantity over time can't be compared; take max, min or at(..., t) of it")
    if isinstance(a, str) != isinstance(b, str):
        raise ExpressionError(f"{a!r} and {b!r} can't be compared: one is a word, one a number")
    if isinstance(a, str) and not isinstance(op, (ast.Eq, ast.NotEq)):
        raise ExpressionError(f"{a!r} and {b!r} are words; compare them by == or !=")
    if any(isinstance(v, float) and math.isnan(v) for v in (a, b)):
        raise Undefined("a side of a comparison is not a number")
    return bool(COMPARISONS[type(op)](a, b))


def _truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise ExpressionError(
            "and, or and not join conditions, such as max(bow) < 0.1; compare with something"
        )
    return value


def _elementwise(function: Callable[[Any, Any], Any], a: Value, b: Value) -> Value:
    """Apply arithmetic; a series with a number, or two series of one run."""
    for one in (a, b):
        if isinstance(one, str):
            raise ExpressionError(f"{one!r} is a word; arithmetic takes numbers and quantities")
    times = [one.time for one in (a, b) if isinstance(one, Series)]
    if len(times) == 2 and not np.array_equal(times[0], times[1]):
        raise ExpressionError("two quantities with different times can't be combined")
    left, right = (one.value if isinstance(one, Series) else float(one) for one in (a, b))
    try:
        found = function(left, right)
    except ZeroDivisionError:
        raise Undefined("a division by zero") from None
    except OverflowError:
        raise Undefined(BEYOND) from None
    if isinstance(found, complex):
        raise Undefined("a root of a negative number")
    found = np.asarray(found, float)
    _still_finite(found, left, right)
    return Series(times[0], found) if times else float(found)


BEYOND = "a number beyond what can be computed with"


def _still_finite(found: Any, *given: Any) -> None:
    """Refuse what arithmetic made infinite, or no number: only a time that never comes is infinite."""
    if np.isfinite(found).all() or not all(np.isfinite(one).all() for one in given):
        return
    if np.isnan(found).any():
        raise Undefined("a root or logarithm of a negative number, or zero by zero")
    raise Undefined(f"a division by zero, or {BEYOND}")


def _plain(value: Any) -> Any:
    """A number of Python's own."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    return float(value) if isinstance(value, (int, float, np.number)) else value


def _series(value: Value, of: str) -> Series:
    if not isinstance(value, Series):
        raise ExpressionError(f"{of} takes a quantity over time; {value!r} is none")
    return value


def _known(value: Value, of: str) -> Series:
    """A quantity that is a number at each time: a comparison with NaN would pass over it."""
    series = _series(value, of)
    if np.isnan(series.value).any():
        raise Undefined(f"{of}: the quantity is not a number at {series.time[np.isnan(series.value)][0]:g} s")
    return series


def _number(value: Value, of: str) -> float:
    if isinstance(value, (Series, str, bool)):
        raise ExpressionError(f"{of} takes a number there")
    if math.isnan(value):
        raise Undefined(f"{of}: one of its values is not a number")
    return value


def _extreme(of: str, best: Callable[[Any], Any]) -> Callable[..., float]:
    def function(*values: Value) -> float:
        if len(values) == 1:
            return float(best(_series(values[0], of).value))
        return float(best([_number(v, of) for v in values]))

    return function


def _each(of: str, function: Callable[[Any], Any]) -> Callable[[Value], Value]:
    def applied(value: Value) -> Value:
        given = value.value if isinstance(value, Series) else _number(value, of)
        found = function(given)
        _still_finite(found, given)
        return Series(value.time, found) if isinstance(value, Series) else float(found)

    return applied


def _mean(value: Value) -> float:
    """Mean over time, by trapezia."""
    series = _series(value, "mean")
    span = series.time[-1] - series.time[0]
    return float(np.trapezoid(series.value, series.time) / span) if span > 0.0 else float(series.value[0])


def _rms(value: Value) -> float:
    series = _series(value, "rms")
    return math.sqrt(max(0.0, _mean(Series(series.time, series.value**2))))


def _at(value: Value, time: Value) -> float:
    series, t = _series(value, "at"), _number(time, "at")
    if not series.time[0] <= t <= series.time[-1]:
        raise Undefined(f"at {t:g} s: the run is from {series.time[0]:g} to {series.time[-1]:g} s")
    return float(np.interp(t, series.time, series.value))


def _settling_time(value: Value, band: Value, target: Value | None = None) -> float:
    """s after which a quantity stays within a band of a target, else of its last value; inf if never."""
    series, half = _known(value, "settling_time"), _number(band, "settling_time")
    if not half >= 0.0:
        raise ExpressionError(f"settling_time: the band is {half:g}; give at least 0")
    goal = float(series.value[-1]) if target is None else _number(target, "settling_time")
    outside = np.flatnonzero(np.abs(series.value - goal) > half)
    if not len(outside):
        return float(series.time[0])
    last = int(outside[-1])
    return float(series.time[last + 1]) if last + 1 < len(series.time) else math.inf


def _first_time(value: Value, limit: Value) -> float:
    """s at which a quantity first is at a level or above, straight between samples; inf where never."""
    series, level = _known(value, "first_time"), _number(limit, "first_time")
    over = np.flatnonzero(series.value >= level)
    if not len(over):
        return math.inf
    k = int(over[0])
    if k == 0:
        return float(series.time[0])
    share = (level - series.value[k - 1]) / (series.value[k] - series.value[k - 1])
    return float(series.time[k - 1] + share * (series.time[k] - series.time[k - 1]))


FUNCTIONS: dict[str, tuple[Callable[..., Any], int, int]] = {
    "max": (_extreme("max", np.max), 1, 20),
    "min": (_extreme("min", np.min), 1, 20),
    "mean": (_mean, 1, 1),
    "rms": (_rms, 1, 1),
    "integral": (lambda s: float(np.trapezoid(_series(s, "integral").value, s.time)), 1, 1),
    "final": (lambda s: float(_series(s, "final").value[-1]), 1, 1),
    "initial": (lambda s: float(_series(s, "initial").value[0]), 1, 1),
    "at": (_at, 2, 2),
    "settling_time": (_settling_time, 2, 3),
    "first_time": (_first_time, 2, 2),
    "time_of_max": (lambda s: float(s.time[np.argmax(_known(s, "time_of_max").value)]), 1, 1),
    "abs": (_each("abs", np.abs), 1, 1),
    "sqrt": (_each("sqrt", np.sqrt), 1, 1),
    "exp": (_each("exp", np.exp), 1, 1),
    "log": (_each("log", np.log), 1, 1),
}
"""Name: function, and how many values it takes, at least and at most."""
ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: a**b,
}
COMPARISONS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Lt: lambda a, b: a < b,
    ast.LtE: lambda a, b: a <= b,
    ast.Gt: lambda a, b: a > b,
    ast.GtE: lambda a, b: a >= b,
    ast.Eq: lambda a, b: a == b,
    ast.NotEq: lambda a, b: a != b,
}
