"""xacro unfolded to a URDF's text by the package of that name, where it is installed."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Mapping
from pathlib import Path

from .xml_file import ImportRefused, read_xml

# where an argument is declared, or used
ARGUMENT = re.compile(r"""<xacro:arg\s+name\s*=\s*["']([^"']+)["']|\$\(arg\s+([^)\s]+)\s*\)""")


def unfold(path: Path, values: Mapping[str, str]) -> bytes:
    """The URDF of a xacro file.

    Parameters
    ----------
    values : its arguments, as `xacro IN.xacro NAME:=VALUE` takes them

    Raises
    ------
    ImportRefused
        where xacro is not installed, or can't unfold the file
    """
    by_hand = f"xacro {path} > {path.name.split('.')[0]}.urdf"
    read_xml(path)  # refuses what is no XML or has a DOCTYPE
    try:
        import xacro
    except ImportError:
        raise ImportRefused(
            f"{path}: is xacro, for which the package xacro is not installed; pip install 'flexsim[xacro]',"
            f" or convert it where it is: {by_hand}"
        ) from None
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            document = xacro.process_file(str(path), mappings=dict(values))
        text = bytes(document.toprettyxml(indent="  ", encoding="utf-8"))
    except (Exception, SystemExit) as problem:  # xacro raises many kinds, and may end the program
        words = [*str(problem).split(), *said.getvalue().split()][:40]
        reason = " ".join(words) or type(problem).__name__
        raise ImportRefused(
            f"{path}: xacro can't unfold it: {reason}; give its arguments with --arg NAME:=VALUE, or, where"
            f" its packages are installed: {by_hand}"
        ) from None
    check_arguments(path, [path, *map(Path, xacro.all_includes)], values)
    return text


def check_arguments(path: Path, files: list[Path], values: Mapping[str, str]) -> None:
    """Refuse arguments that no file of the xacro has: xacro itself passes over them."""
    known = {
        name
        for file in files
        for pair in ARGUMENT.findall(file.read_text("utf-8", "replace"))
        for name in pair
    }
    for name in values:
        if name not in known:
            right = ", ".join(sorted(known - {""})) or "none"
            raise ImportRefused(f"{path}: --arg {name}: the xacro has no such argument; it has {right}")
