"""Every example of the documentation, found by rule, so that a new one can't be forgotten.

Found in README.md and docs/*.md: the lines of ```bash blocks, the command lines of indented blocks and of
`inline code`, and the Python of fenced and indented blocks.  Found in the --help of each verb: the lines
below "Example:".  Inline code with a word in capitals in place of a file or a value (SCENE, LAW) shows how a
command is built, and is no example.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import click
from flexsim.cli import flexsim

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROGRAMS = (
    "flexsim",
    "flexsim_node",
    "thermal_node",
    "make",
    "python",
    "ros2",
    "colcon",
    "cd",
    "export",
    "git",
)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?<=\n\n)(?:    .*\n|\n(?=    ))+")
INLINE = re.compile(r"`([^`\n]+)`")
PLACEHOLDER = re.compile(r"(?<![\w=/$])[A-Z][A-Z|\\]{2,}\b(?!\.rrd)|\b[A-Z]+\.(?:yaml|csv|urdf)\b|<")


def commands() -> dict[str, list[str]]:
    """Return each documented command line, without its comment, and where it stands."""
    found: dict[str, list[str]] = {}
    for line, place in [*on_pages(), *in_help()]:
        words = line.partition("  #")[0].strip()
        found.setdefault(words, []).append(place)
    return found


def on_pages() -> Iterator[tuple[str, str]]:
    """Yield the command lines of the pages."""
    for page in PAGES:
        text = page.read_text()
        for language, block in FENCE.findall(text):
            if language == "bash":
                yield from ((line, page.name) for line in lines_of(block))
        text = FENCE.sub("", text)
        for block in INDENTED.findall(text):
            yield from ((line, page.name) for line in lines_of(block) if is_command(line))
        for code in INLINE.findall(text):
            if is_command(code) and has_arguments(code) and not PLACEHOLDER.search(code):
                yield code, page.name


def in_help() -> Iterator[tuple[str, str]]:
    """Yield the examples of each verb's help."""
    for name, verb in verbs(flexsim, "flexsim"):
        shown = (verb.help or "").partition("Example:\n")[2].partition("\n\n")[0]
        lines = lines_of(shown)
        assert lines, f"{name} --help has no example"
        yield from ((line, f"{name} --help") for line in lines)


def verbs(group: click.Group, name: str) -> Iterator[tuple[str, click.Command]]:
    """Yield the verbs below a group, those of groups within it too."""
    context = click.Context(group)
    for word in group.list_commands(context):
        verb = group.get_command(context, word)
        assert verb is not None
        yield f"{name} {word}", verb
        if isinstance(verb, click.Group):
            yield from verbs(verb, f"{name} {word}")


def lines_of(block: str) -> list[str]:
    """Return a block's lines, those that go on behind a backslash joined."""
    joined = re.sub(r"\\\n\s*", "", block)
    return [line.strip() for line in joined.splitlines() if line.strip()]


def is_command(line: str) -> bool:
    """Say whether a line begins with a program."""
    return line.split()[0] in PROGRAMS and not line.startswith(("flexsim_node:", "thermal_node:"))


def has_arguments(code: str) -> bool:
    """Say whether inline code is a command to type; else it is a verb's name, perhaps with an option's."""
    names = {"flexsim": 2, "python": 3 if " -m " in code else 1}  # flexsim VERB, python -m MODULE
    words = code.split()
    return any(not word.startswith("-") for word in words[names.get(words[0], 1) :])


def programs() -> dict[str, str]:
    """Return the Python of each page, all blocks of a page one program."""
    found: dict[str, str] = {}
    for page in PAGES:
        text = page.read_text()
        blocks = [block for language, block in FENCE.findall(text) if language == "python"]
        for block in INDENTED.findall(FENCE.sub("", text)):
            if re.match(r"\s*(from|import) \w", block):
                blocks.append(re.sub(r"^    ", "", block, flags=re.MULTILINE))
        if blocks:
            found[page.name] = "\n".join(blocks)
    return found
