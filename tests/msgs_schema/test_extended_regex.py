"""Filters from the network: POSIX extended regular expressions that can neither hang nor fill the memory."""

from __future__ import annotations

import random
import re
import time
import warnings

import pytest
from flexsim_ros.extended_regex import ExtendedRegex, RegexError


def test_it_agrees_with_pythons_own_where_the_two_languages_do() -> None:
    """Random expressions of the common part, on words of the same letters."""
    rng = random.Random(1)
    words = ["", "a", "b", "ab", "aab", "abba", "x-b", "22", "ba" * 10]
    compared = 0
    for _ in range(8000):
        text = "".join(rng.choice("ab.*+?|()[^]x-") for _ in range(rng.randint(1, 9)))
        if re.search(r"[*+?][*+?]|\[\]|\[\^\]|\[[^]]*\[", text):
            continue  # here the languages differ: lazy and possessive counts, brackets in brackets
        try:
            ours = ExtendedRegex(text)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                theirs = re.compile(text)
        except (RegexError, re.error):
            continue
        for word in words:
            assert ours.matches(word) == (theirs.fullmatch(word) is not None), (text, word)
            compared += 1
    assert compared > 5000


@pytest.mark.parametrize(
    ("text", "matching", "other"),
    [
        ("link_[0-9]+", "link_12", "link_"),
        ("[[:alpha:]_]+/link_[12]", "arm/link_2", "arm/link_3"),
        ("a{2,3}", "aaa", "aaaa"),
        ("(ab){0}c", "c", "abc"),
        ("^arm$", "arm", "arm2"),
        (r"a\.b", "a.b", "axb"),
        ("[]x]*", "]x]", "y"),
        ("[^/]*", "arm", "arm/link"),
        ("arm|door", "door", "armdoor"),
        ("[a-]+", "a-a", "b"),
    ],
)
def test_what_posix_says(text: str, matching: str, other: str) -> None:
    assert ExtendedRegex(text).matches(matching)
    assert not ExtendedRegex(text).matches(other)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("(a", "not closed"),
        ("a)", "no '('"),
        ("[a", "not closed"),
        ("*a", "nothing is before"),
        ("a{3,2}", "runs backwards"),
        ("[b-a]", "runs backwards"),
        ("[[:foo:]]", "no class"),
        ("a\\", "nothing is behind"),
        ("((a{1,255}){1,255}){1,255}", "too many"),
        ("(){9999}{9999}{9999}", "too many"),
        ("(" * 60, "too many brackets"),
        ("a" * 1001, "at most 1000"),
    ],
)
def test_what_is_no_expression(text: str, sentence: str) -> None:
    with pytest.raises(RegexError, match=re.escape(sentence)):
        ExtendedRegex(text)


def test_the_worst_expressions_take_no_time() -> None:
    """Those that take a backtracking matcher longer than the universe lasts."""
    begun = time.monotonic()
    for text in ("(a+)+", "(a|a)*b", "(a*)*(a*)*b", "(a?){40}a{40}"):
        assert not ExtendedRegex(text).matches("a" * 39 + "!")
    assert time.monotonic() - begun < 5.0
