"""Message definitions and type hashes, from the share folders of the installed packages."""

from __future__ import annotations

import json
import os
import re
import sys
from functools import cache
from pathlib import Path

from .errors import BagError

PRIMITIVES = {"bool", "byte", "char", "float32", "float64", "string", "wstring"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}
FIELD = re.compile(r"^([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]\w*")
TYPE_NAME = re.compile(r"[A-Za-z]\w*/(msg|srv|action)/[A-Za-z]\w*\Z")
CONSTANT = re.compile(r"^[\w/<=]+\s+[A-Za-z]\w*\s*=")


def prefixes() -> list[Path]:
    """Return where ROS packages may be installed: sourced workspaces first, then this Python."""
    sourced = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    return [*sourced, Path(sys.prefix)]


def message_file(type_name: str, suffix: str) -> Path:
    """Return the file that describes `pkg/msg/Type`; raises BagError where none is installed."""
    if not TYPE_NAME.match(type_name):  # it may come from a file, and be a path
        raise BagError(f"{type_name!r} is no name of a message type")
    package, _, rest = type_name.partition("/")
    for prefix in prefixes():
        path = prefix / "share" / package / f"{rest}{suffix}"
        if path.is_file():
            return path
    raise BagError(f"no definition of {type_name} is installed (package {package})")


@cache
def definition(type_name: str) -> str:
    """Return the text of `pkg/msg/Type` and of all it depends on, as MCAP's ros2msg wants it."""
    parts = [message_file(type_name, ".msg").read_text(encoding="utf-8")]
    seen = {type_name}

    def visit(name: str) -> None:
        for dependency in sorted(dependencies(name)):
            if dependency not in seen:
                seen.add(dependency)
                text = message_file(dependency, ".msg").read_text(encoding="utf-8")
                package, _, short = dependency.split("/")
                parts.append(f"\n{'=' * 80}\nMSG: {package}/{short}\n{text}")
                visit(dependency)

    visit(type_name)
    return "".join(parts)


def dependencies(type_name: str) -> set[str]:
    """Return the message types that the fields of `pkg/msg/Type` name."""
    package = type_name.partition("/")[0]
    found = set()
    for line in message_file(type_name, ".msg").read_text(encoding="utf-8").splitlines():
        line = line.partition("#")[0].strip()
        match = FIELD.match(line)
        if match and not CONSTANT.match(line) and match[1] not in PRIMITIVES:
            found.add(full_name(match[1], package))
    return found


def full_name(name: str, package: str) -> str:
    """Return `pkg/msg/Type` for a field's type as it is written in a message of `package`."""
    if "/" not in name:
        return f"{package}/msg/{name}"
    first, _, last = name.partition("/")
    return f"{first}/msg/{last.removeprefix('msg/')}"


@cache
def type_hash(type_name: str) -> str:
    """Return the type's `RIHS01_...`, or '' where the package carries none."""
    try:
        described = json.loads(message_file(type_name, ".json").read_text(encoding="utf-8"))
    except BagError:
        return ""
    for entry in described["type_hashes"]:
        if entry["type_name"] == type_name:
            return str(entry["hash_string"])
    return ""
