"""A file that a command is to write: refused before the work where it can't be meant."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click


class OutputFile(click.Path):
    """The name of a file to write, which ends as what is written does.

    So a slip of the keyboard does not cost the bag or the scene that has the name.

    Parameters
    ----------
    endings : str
        For example ".html", ".htm".
    """

    def __init__(self, *endings: str) -> None:
        super().__init__(dir_okay=False)
        self.endings = endings

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name; fails where its ending is another."""
        name = os.fsdecode(super().convert(value, param, ctx))
        if not name.lower().endswith(self.endings):
            self.fail(f"'{name}' does not end in {' or '.join(self.endings)}", param, ctx)
        parent = Path(name).absolute().parent
        if not parent.is_dir():
            raise click.ClickException(f"{Path(name).parent} does not exist; make it first")
        return name
