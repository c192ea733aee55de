"""What a study may ask of a run: right values, and nothing but the grammar."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flexsim.sweep.expression import Absent, Expression, ExpressionError, Series, Undefined

TIME = np.linspace(0.0, 2.0, 201)
DECAY = Series(TIME, np.exp(-3.0 * TIME) * np.cos(20.0 * TIME))
OUTPUTS = {
    "decay": DECAY,
    "ramp": Series(TIME, 3.0 * TIME),
    "count": 4.0,
    "word": "A-60",
    "holds": True,
    "probe": {"tc_1": DECAY, "tc_2": Series(TIME, TIME)}.__getitem__,
    "bow": Absent("the scene computes no deformation"),
    "never": math.inf,
    "none": math.nan,
    "gappy": Series(TIME, np.where(TIME[50] == TIME, np.nan, TIME)),
}
KNOWN = frozenset(OUTPUTS)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("max(ramp) - 2 * min(ramp)", 6.0),
        ("mean(ramp)", 3.0),
        ("rms(ramp - 3)", math.sqrt(3.0)),
        ("integral(ramp)", 6.0),
        ("final(ramp) / initial(ramp + 1)", 6.0),
        ("at(ramp, 0.005)", 0.015),
        ("first_time(ramp, 1.5)", 0.5),
        ("first_time(ramp, 100)", math.inf),
        ("time_of_max(abs(probe('tc_2') - 1))", 0.0),
        ("max(1, count, -2) ** 0.5", 2.0),
        ("sqrt(count) + exp(0) + log(1)", 3.0),
        ("max(2 - ramp ** 2)", 2.0),
        ("1 < count <= 4 and word == 'A-60'", True),
        ("not holds or count != 4", False),
        ("word", "A-60"),
        ("-count", -4.0),
        ("never > 1e9", True),
    ],
)
def test_values(text: str, value: object) -> None:
    found = Expression(text, KNOWN)(OUTPUTS)
    assert type(found) is type(value)
    assert found == (pytest.approx(value, rel=1e-4) if isinstance(value, float) else value)


def test_settling_time_is_when_it_stays() -> None:
    """After it the quantity is within the band for good, before it is not."""
    found = Expression("settling_time(decay, 0.05, 0)", KNOWN)(OUTPUTS)
    after = found <= TIME
    assert (np.abs(DECAY.value[after]) <= 0.05).all()
    assert abs(DECAY.value[~after][-1]) > 0.05
    assert Expression("settling_time(ramp, 0.1, 0)", KNOWN)(OUTPUTS) == math.inf
    assert Expression("settling_time(decay, 9)", KNOWN)(OUTPUTS) == 0.0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("__import__('os').system('touch /tmp/x')", "a call of this kind is not allowed"),
        ("open('/etc/passwd')", "'open' is not known"),
        ("count.__class__", "Attribute is not allowed"),
        ("().__class__.__bases__[0]", "Subscript is not allowed"),
        ("(lambda: 1)()", "a call of this kind"),
        ("[x for x in (1, 2)]", "ListComp is not allowed"),
        ("max(ramp, key=probe)", "a call of this kind"),
        ("max(*ramp)", "Starred is not allowed"),
        ("f'{count}'", "JoinedStr is not allowed"),
        ("count := 1", "can't be read"),
        ("(count := 1)", "NamedExpr is not allowed"),
        ("1 if holds else 2", "IfExp is not allowed"),
        ("count << 60", "LShift is not allowed"),
        ("count @ count", "MatMult is not allowed"),
        ("~count", "UnaryOp is not allowed"),
        ("count in word", "Compare is not allowed"),
        ("1j", "1j is not allowed"),
        ("b'x'", "is not allowed"),
        ("...", "is not allowed"),
        ("None", "None is not allowed"),
        ("count\0", "can't be read"),
        ("count; count", "can't be read"),
        ("", "can't be read"),
        ("(" * 300 + "1" + ")" * 300, "can't be read"),
        ("-" * 200 + "1", "nested more than 30 deep"),
        ("1" * 2000, "2000 characters"),
        ("1" + "0" * 400, "beyond 1e300"),
        ("maxx(ramp)", "did you mean 'max'?"),
        ("at(ramp)", "at takes 2 values, not 1"),
    ],
)
def test_what_is_no_expression_is_refused_before_anything_is_run(text: str, sentence: str) -> None:
    with pytest.raises(ExpressionError, match=r"^[^\n]*$") as refused:
        Expression(text, KNOWN)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("ramp", "is a quantity over time"),
        ("ramp < 3", "can't be compared"),
        ("max(word)", "takes a quantity over time"),
        ("word < 'B'", "are words"),
        ("word == 4", "one is a word, one a number"),
        ("word * 1000000000", "is a word"),
        ("count and holds", "join conditions"),
        ("max(bow)", "the scene computes no deformation"),
        ("probe", "needs a name in brackets"),
        ("count('x')", "takes nothing in brackets"),
        ("probe('tc_1', 2)", "does not take 2 such values"),
        ("at(ramp, word)", "takes a number there"),
        ("settling_time(ramp, -1)", "give at least 0"),
    ],
)
def test_what_can_be_of_no_run_is_an_error(text: str, sentence: str) -> None:
    with pytest.raises(ExpressionError, match=r"^[^\n]*$") as refused:
        Expression(text, KNOWN)(OUTPUTS)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    "text",
    [
        "1 / (count - 4)",
        "10 ** 1000",
        "(-count) ** 0.5",
        "log(-1)",
        "never - never",
        "none",
        "none < 1",
        "at(ramp, 5)",
        "max(1 / ramp)",
        "final(ramp / (ramp - 6))",
        "1e200 * 1e200",
        "max(ramp * 1e308 * 10)",
        "log(0)",
        "max(-log(ramp))",
        "exp(1000)",
        "first_time(gappy, 1)",
        "time_of_max(gappy)",
        "settling_time(gappy, 0.1)",
        "max(gappy)",
        "first_time(ramp, none)",
        "settling_time(ramp, 0.1, none)",
    ],
)
def test_what_has_no_value_for_a_run_fails_that_run(text: str) -> None:
    """Never a NaN in the table, and never an infinity but that of a time that does not come."""
    with pytest.raises(Undefined):
        Expression(text, KNOWN)(OUTPUTS)


def test_how_far_a_condition_is_broken() -> None:
    """0 exactly where it holds; else the distance, which guides a search."""
    for text, excess in [
        ("count < 4", 1e-300),
        ("count <= 4", 0.0),
        ("count >= 6 and count <= 1", 5.0),
        ("count >= 6 or count <= 1", 2.0),
        ("not holds", 1.0),
        ("word == 'B-15'", 1.0),
        ("never <= 3", 1.0),
        ("count > 1", 0.0),
    ]:
        made = Expression(text, KNOWN)
        assert made.excess(OUTPUTS) == excess
        assert (made.excess(OUTPUTS) == 0.0) is made(OUTPUTS)
