"""The `flexsim` command line: finds a verb's file by its name and runs it.

A verb is a file of verbs/ that defines `command`, a `click.Command`. Its imports at the
top must be light; what is heavy (rclpy, numba, rerun) is imported when the verb runs, so that
`flexsim --help` answers at once.
"""

from __future__ import annotations

import difflib
import importlib
import keyword
import os
import pkgutil
import sys
import traceback
import warnings
from pathlib import Path
from typing import Any

import click
from flexsim_ros.first_instant import SCRIPTS
from flexsim_ros.start import attentive

from .terminal.own_output import own_output
from .terminal.plain import plain
from .terminal.report import say

PACKAGE = __name__.rpartition(".")[0]
EXPECTED_FAILURES = (OSError, ValueError, RuntimeError, LookupError, ArithmeticError)


class Verbs(click.Group):
    """A click group whose commands are the files of verbs/."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the verbs' names, alphabetically."""
        files = pkgutil.iter_modules([str(Path(__file__).parent / "verbs")])
        return sorted(m.name.rstrip("_").replace("_", "-") for m in files)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the verb's file, or return None where there is none."""
        if cmd_name not in self.list_commands(ctx):
            return None
        name = cmd_name.replace("-", "_")
        name += "_" * keyword.iskeyword(name)  # import is a word of Python's own
        module = importlib.import_module(f"{PACKAGE}.verbs.{name}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the verb; where it does not exist, name the nearest one."""
        verbs = self.list_commands(ctx)
        if args and not args[0].startswith("-") and args[0] not in verbs:
            near = difflib.get_close_matches(args[0], verbs, n=1, cutoff=0.5)
            hint = f"Did you mean '{near[0]}'?" if near else f"Verbs: {', '.join(verbs)}."
            raise click.UsageError(f"No verb '{args[0]}'. {hint}", ctx)
        return super().resolve_command(ctx, args)


@click.command(
    cls=Verbs,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    subcommand_metavar="VERB [ARGS]...",
    epilog="Each verb has its own --help with an example.",
)
def flexsim() -> None:
    """Flexible robots and fire doors in real time: simulate, record, look."""


def main() -> None:
    """Run the command; exit with 0 done, 1 the work failed, 2 the words were wrong, 130 a signal came."""
    code: Any
    stopped = SCRIPTS["flexsim"]
    try:
        with attentive("flexsim", stopped):
            own_output()
            warnings.showwarning = said_plainly
            code = flexsim.main(prog_name="flexsim", standalone_mode=False)
    except click.ClickException as error:
        error.__dict__["message"] = plain(error.message, "\n\t")
        error.show()
        code = error.exit_code
    except (KeyboardInterrupt, click.Abort):
        code = stopped
    except BrokenPipeError:
        # The reader of a pipe (head, less) has gone: nobody is left to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    except Exception as error:
        if os.environ.get("FLEXSIM_TRACEBACK"):
            traceback.print_exc()
        say(f"Error: {describe(error)}", err=True)
        code = 1
    sys.exit(code if isinstance(code, int) else 0)


def said_plainly(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    """Show a warning as a sentence; what is only for programmers is left out."""
    if issubclass(category, UserWarning):
        say(f"Warning: {message}", err=True)


def describe(error: Exception) -> str:
    """Say in one line what went wrong."""
    if isinstance(error, EXPECTED_FAILURES) and str(error):
        return str(error)
    kind = type(error).__name__
    return f"unexpected {kind}: {error} (FLEXSIM_TRACEBACK=1 shows where)"
