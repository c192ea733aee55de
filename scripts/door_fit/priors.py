"""What is known of parameters before a fit, as words of a command."""

from __future__ import annotations

from collections.abc import Sequence

import click


def prior(given: str) -> tuple[str, tuple[float, float]]:
    """Return a prior's key, value and standard deviation from KEY=VALUE±DEVIATION."""
    key, equals, rest = given.partition("=")
    value, _, deviation = rest.replace("+-", "±").replace("+/-", "±").partition("±")
    try:
        if not equals:
            raise ValueError
        return key.strip(), (float(value), float(deviation))
    except ValueError:
        raise click.UsageError(f"--prior {given}: give KEY=VALUE±DEVIATION, such as density=120±6") from None


def priors(given: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return value and standard deviation by key; refuse a key that is given twice."""
    found: dict[str, tuple[float, float]] = {}
    for words in given:
        key, known = prior(words)
        if key in found:
            raise click.UsageError(f"--prior {words}: {key} has a prior already; give each once")
        found[key] = known
    return found
