"""The words of `--set KEY=VALUE`."""

from __future__ import annotations

from typing import Any

import click


def setting(words: str) -> tuple[str, Any]:
    """Read KEY=VALUE, the value as YAML says it."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    key, equals, value = words.partition("=")
    if not (key and equals):
        raise click.UsageError(f"--set {words}: give KEY=VALUE, such as solver.step=5e-4")
    try:
        return key, number(value) if number(value) is not None else YAML(typ="safe").load(value)
    except YAMLError:
        raise click.UsageError(f"--set {words}: {value!r} is not a YAML value") from None


def number(text: str) -> int | float | None:
    """Read a number; YAML takes 5e-4, without a point, for a word."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return None
