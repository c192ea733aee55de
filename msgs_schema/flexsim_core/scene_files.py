"""Scene files: YAML read safely, keys replaced from outside, and the line where a key stands."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.nodes import MappingNode, SequenceNode

LARGEST_FILE = 2**20  # bytes
MOST_VALUES, DEEPEST = 1_000_000, 50


class SceneError(ValueError):
    """A scene that can't be simulated: FILE:LINE: key: what is wrong; what would be right."""


def read_scene(path: Path, keys: str) -> Mapping[str, Any]:
    """A scene file's document, with its lines; `keys` names some that a scene has.

    Raises
    ------
    SceneError
        where it is no file of a moderate size, no YAML, or no mapping
    """
    try:
        size = path.stat().st_size
        if not path.is_file() or size > LARGEST_FILE:  # a device may never end, a pipe never begin
            raise SceneError(f"{path}: is no file of at most {LARGEST_FILE} bytes; give a YAML file")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file; give the path of a scene") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise SceneError(f"{path}: can't be read ({problem}); give a YAML file") from None
    try:
        document = YAML(typ="rt", pure=True).load(text)
    except DuplicateKeyError as problem:
        key, line, first = _twice(text, problem)
        raise SceneError(
            f"{path}:{line}: not YAML: found duplicate key {key!r}, which is in line {first} already;"
            " give each its own name"
        ) from None
    except MarkedYAMLError as problem:
        mark = problem.problem_mark
        line = mark.line + 1 if mark else 1
        raise SceneError(f"{path}:{line}: not YAML: {problem.problem}; mend it there") from None
    except Exception as problem:  # ruamel raises several kinds for broken documents
        raise SceneError(f"{path}: not YAML: {problem}") from None
    if not isinstance(document, Mapping):
        raise SceneError(f"{path}:1: not a scene; give keys such as {keys}")
    count_values(document, str(path))
    return document


def _twice(text: str, problem: DuplicateKeyError) -> tuple[str, int, int]:
    """A key that a mapping of a YAML text has twice, and the lines (from 1) of the second and the first."""
    again = problem.problem_mark
    waiting, seen = [YAML(typ="rt", pure=True).compose(text)], set()
    while waiting:
        node = waiting.pop()
        if id(node) in seen:
            continue  # an alias
        seen.add(id(node))
        if isinstance(node, SequenceNode):
            waiting.extend(node.value)
        elif isinstance(node, MappingNode):
            waiting.extend(part for pair in node.value for part in pair)
            keys = [key for key, _ in node.value]
            for key in keys:
                if key.start_mark.index == again.index:
                    first = next(k for k in keys if k.value == key.value)
                    return str(key.value), again.line + 1, first.start_mark.line + 1
    return "", again.line + 1, again.line + 1


def count_values(document: Any, source: str) -> None:
    """Refuse a document whose aliases stand for ever more of themselves, before it is unfolded."""
    count, waiting = 0, [(document, 0)]
    while waiting:
        value, depth = waiting.pop()
        count += 1
        if count > MOST_VALUES or depth > DEEPEST:
            raise SceneError(
                f"{source}: unfolds to more than {MOST_VALUES} values or {DEEPEST} levels;"
                " give fewer YAML aliases"
            )
        if isinstance(value, Mapping):
            waiting.extend((v, depth + 1) for v in value.values())
        elif isinstance(value, (list, tuple)):
            waiting.extend((v, depth + 1) for v in value)


def plain(value: Any) -> Any:
    """Nested dicts, lists and numbers of Python's own, from ruamel's or NumPy's.

    Raises
    ------
    SceneError
        where two keys are one word: 1 and "1"
    """
    if isinstance(value, Mapping):
        words: dict[str, Any] = {}
        for key in value:
            if str(key) in words:
                raise SceneError(
                    f"scene: keys {words[str(key)]!r} and {key!r} are one name; give each its own"
                )
            words[str(key)] = key
        return {str(k): plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, bool) or value is None:
        return value
    for kind in (int, float, str):
        if isinstance(value, kind):
            return kind(value)
    return value


def override(document: dict[str, Any], key: str, value: Any, tables: Collection[str] = ()) -> str:
    """Set a dotted key in a plain document: `links.0.beam.elements`, or by name `links.link_1.beam.elements`.

    tables : keys whose plain value gives way to keys below it

    Returns the key with list entries by number.

    Raises
    ------
    SceneError
        where the key leads nowhere
    """
    parts = key.split(".")
    numbered: list[str] = []
    place: Any = document
    for n, part in enumerate(parts):
        last = n == len(parts) - 1
        above = ".".join(parts[:n])
        if isinstance(place, list):
            at = _entry(place, part, key, above)
            numbered.append(str(at))
            if last:
                place[at] = value
            else:
                place = place[at]
        elif isinstance(place, dict):
            numbered.append(part)
            if last:
                place[part] = value
            else:
                if place.get(part) is None or (part in tables and not isinstance(place[part], (dict, list))):
                    place[part] = {}
                place = place[part]
        else:
            raise SceneError(f"override {key}: {above} is {place!r} and has no keys below it; give {above}")
    return ".".join(numbered)


def _entry(entries: list[Any], part: str, key: str, above: str) -> int:
    """Place in a list of the entry that bears this name, or has this number."""
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in entries]
    if part in names:
        return names.index(part)
    if part.isdigit() and int(part) < len(entries):
        return int(part)
    known = ", ".join(str(name) for name in names if name is not None)
    right = f"one of {known}" if known else f"0 to {len(entries) - 1}" if entries else f"{above} itself"
    raise SceneError(f"override {key}: no {part!r} in {above}; give {right}")


def line_of(document: Any, path: tuple[Any, ...]) -> int | None:
    """Line (from 1) of a key in a document that was read, or of the nearest parent that has one."""
    line = 1 if hasattr(document, "lc") else None
    for key in path:
        try:
            marks = document.lc
            line = (marks.key(key) if isinstance(document, Mapping) else marks.item(key))[0] + 1
            document = document[key]
        except (AttributeError, KeyError, IndexError, TypeError):
            break
    return line
