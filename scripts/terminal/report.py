"""Prints a verb's result on stdout: a table for people, or one JSON object for programs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any

import click

from .plain import plain


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Print a table; a column whose cells are all numbers is set flush right."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    cells = [["" if c is None else plain(str(c), "\n") for c in row] for row in rows]
    table = Table(box=SIMPLE_HEAD, show_edge=False)
    for i, name in enumerate(columns):
        right = bool(cells) and all(is_number(row[i]) for row in cells)
        table.add_column(name, justify="right" if right else "left", overflow="fold")
    for row in cells:
        table.add_row(*row)
    console = Console(highlight=False, markup=False)
    # A file or a pipe has no width: there, nothing is folded.
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=400)
    # Beside the table, not as its title, which rich would fold to the table's width.
    console.print(plain(title), style="bold")
    console.print(table)


def say(sentence: str, *, err: bool = False) -> None:
    """Print a line in which may stand what a file holds: nothing in it that a terminal would obey."""
    click.echo(plain(sentence, "\n\t"), err=err)


def is_number(cell: str) -> bool:
    """Say whether a cell holds a number, or nothing."""
    if not cell:
        return True
    try:
        float(cell)
    except ValueError:
        return False
    return True


def print_json(result: dict[str, Any]) -> None:
    """Print one JSON object; what is not finite becomes null, since JSON has no NaN."""
    click.echo(json.dumps(finite(result), indent=2))


def finite(value: Any) -> Any:
    """Return the value with None in place of numbers that JSON cannot say."""
    if isinstance(value, dict):
        return {str(k): finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(v) for v in value]
    if isinstance(value, float) and value - value != 0.0:
        return None
    return value
