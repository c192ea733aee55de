"""A scene's text with some of its values changed and every other byte as it was.

The text is edited at the positions of its YAML nodes, and read again to see that it says what was meant:
comments, columns, number formats and line ends elsewhere stay, which a parser that dumps can't promise.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingStartEvent,
    ScalarEvent,
    SequenceStartEvent,
)

BYTE_ORDER_MARK = "\ufeff"


class CannotEdit(ValueError):
    """A text that can't be changed so: what stands in the way, and what to do."""


@dataclass
class Node:
    """A YAML node by its place in the text: characters from `start` to before `end`.

    kind : map, list, scalar or alias; flow : whether in braces or brackets
    entries : keys and their nodes of a map; (None, node) of a list
    after : where the key of a map's value ends
    """

    kind: str
    start: int
    end: int
    flow: bool = False
    anchor: str | None = None
    column: int = 0
    entries: list[tuple[Node | None, Node]] = field(default_factory=list)
    text: str = ""
    after: int = 0

    def last(self) -> int:
        """Where its last visible character ends; a block's own end may lie lines below."""
        if self.flow or not self.entries:
            return self.end
        return self.entries[-1][1].last()


def edit(text: str, changes: Mapping[str, Any]) -> str:
    """Return the text with these dotted keys set; what has its value already stays as it is.

    Raises
    ------
    CannotEdit
        Where the text is no YAML mapping, or would not say what was meant; nothing is half done.
    """
    mark = BYTE_ORDER_MARK if text.startswith(BYTE_ORDER_MARK) else ""
    text = text[len(mark) :]
    wanted = plain(text)
    for dotted, value in changes.items():
        put(wanted, dotted, value)
    for dotted, value in changes.items():
        path = keys_of(plain(text), dotted)
        text = _set(text, path, _pure(value))
    if plain(text) != wanted:
        raise CannotEdit("its anchors and aliases tie other values to these; write them out")
    return mark + text


def plain(text: str) -> Any:
    """What a text says, in dicts and lists."""
    try:
        found = YAML(typ="safe", pure=True).load(text)
    except YAMLError as problem:
        raise CannotEdit(f"not YAML: {' '.join(str(problem).split())[:200]}") from None
    if not isinstance(found, dict):
        raise CannotEdit("not a scene; it has no keys")
    return _pure(found)


def keys_of(document: Any, dotted: str) -> list[str | int]:
    """A dotted key as keys and numbers; list entries may be called by name."""
    path: list[str | int] = []
    for part in dotted.split("."):
        if isinstance(document, list):
            names = [item.get("name") if isinstance(item, dict) else None for item in document]
            at = names.index(part) if part in names else int(part) if part.isdigit() else -1
            if not 0 <= at < len(document):
                raise CannotEdit(f"{dotted}: there is no {part}")
            path.append(at)
            document = document[at]
        else:
            path.append(part)
            document = document.get(part) if isinstance(document, dict) else None
    return path


def put(document: Any, dotted: str, value: Any) -> None:
    """Set a dotted key in dicts and lists; what has no keys below it gives way to keys."""
    path: list[Any] = list(keys_of(document, dotted))
    for key in path[:-1]:
        below = document[key] if isinstance(document, list) else document.get(key)
        if not isinstance(below, (dict, list)):
            below = {}
            document[key] = below
        document = below
    document[path[-1]] = _pure(value)


def _pure(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _pure(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_pure(v) for v in value]
    return value.item() if hasattr(value, "item") else value


# Reading places


def tree(text: str) -> Node:
    """The text's root node."""
    events = list(YAML(typ="safe", pure=True).parse(text))
    starts = sum(isinstance(e, DocumentStartEvent) for e in events)
    if starts > 1:
        raise CannotEdit(f"holds {starts} documents; give one")
    at = next(n for n, e in enumerate(events) if isinstance(e, DocumentStartEvent)) + 1
    return _node(events, at)[0]


def _node(events: list[Event], at: int) -> tuple[Node, int]:
    e = events[at]
    start, end = e.start_mark.index, e.end_mark.index
    if isinstance(e, AliasEvent):
        return Node("alias", start, end, text=e.anchor), at + 1
    if isinstance(e, ScalarEvent):
        return Node("scalar", start, end, True, e.anchor, e.start_mark.column, text=str(e.value)), at + 1
    kind = "map" if isinstance(e, MappingStartEvent) else "list"
    assert isinstance(e, (MappingStartEvent, SequenceStartEvent))
    found = Node(kind, start, end, bool(e.flow_style), e.anchor, e.start_mark.column)
    at += 1
    while not type(events[at]).__name__.endswith("EndEvent"):
        key: Node | None = None
        if kind == "map":
            key, at = _node(events, at)
        value, at = _node(events, at)
        value.after = 0 if key is None else key.end
        found.entries.append((key, value))
    found.end = events[at].end_mark.index
    if not found.flow and found.entries:
        first = found.entries[0][0] or found.entries[0][1]
        found.column = first.column if kind == "map" else found.column
    return found, at + 1


def _anchors(node: Node) -> list[Node]:
    own = [node] if node.kind == "alias" else []
    for key, value in node.entries:
        own += ([] if key is None else _anchors(key)) + _anchors(value)
    return own


# Changing them


def _set(text: str, path: list[str | int], value: Any) -> str:
    """Set one key."""
    document = plain(text)
    if _has(document, path) and _same(_get(document, path), value):
        return text
    node, here = tree(text), document
    for n, key in enumerate(path):
        if node.kind == "alias":
            return _replaced(text, node, _with(here, path[n:], value))
        if node.anchor is not None:
            tied = [a for a in _anchors(tree(text)) if a.text == node.anchor]
            if tied:  # they keep what they have: written out where they stand
                last = tied[-1]
                return _set(text[: last.start] + flow(here) + text[last.end :], path, value)
        child = _child(node, key)
        if child is None and isinstance(here, dict) and isinstance(key, str):
            below = here.get(key)  # from a merge
            whole = value if n == len(path) - 1 else _with(below, path[n + 1 :], value)
            if node.kind == "scalar":
                return _replaced(text, node, {key: whole})
            return _inserted(text, node, key, whole)
        if child is None:  # keys below what has none
            return _replaced(text, node, _with(None, path[n:], value))
        node, here = child, here[key]
    if node.kind == "list" and isinstance(value, list) and len(value) == len(node.entries):
        for n, (old, new) in enumerate(zip(here, value, strict=True)):
            if not _same(old, new):
                text = _set(text, [*path, n], new)
        return text
    return _replaced(text, node, value)


def _child(node: Node, key: str | int) -> Node | None:
    if node.kind == "list" and isinstance(key, int):
        return node.entries[key][1]
    if node.kind == "map":
        return next((v for k, v in node.entries if k is not None and k.text == str(key)), None)
    return None


def _get(document: Any, path: list[str | int]) -> Any:
    for key in path:
        document = document[key]
    return document


def _has(document: Any, path: list[str | int]) -> bool:
    try:
        _get(document, path)
    except (KeyError, IndexError, TypeError):
        return False
    return True


def _with(document: Any, path: list[str | int], value: Any) -> Any:
    """A document with one key set, in copies."""
    if not path:
        return value
    if isinstance(document, list):
        k = path[0]
        return [_with(v, path[1:], value) if n == k else v for n, v in enumerate(document)]
    below = dict(document) if isinstance(document, dict) else {}
    below[path[0]] = _with(below.get(path[0]), path[1:], value)
    return below


def _same(a: Any, b: Any) -> bool:
    """Equal, and of one kind: 1 and true are not the same, 1 and 1.0 are."""
    return a == b and isinstance(a, bool) == isinstance(b, bool)


def _replaced(text: str, node: Node, value: Any) -> str:
    """Put a value where a node is, keeping what stands around it, an anchor included."""
    start, end = node.start, node.last()
    if node.kind == "scalar" and start == end:  # nothing stands there yet: right after the key's colon
        at = text.index(":", node.after) + 1 if node.after else start
        return text[:at] + " " + flow(value) + text[at:]
    if node.anchor is not None:
        found = re.match(rf"&{re.escape(node.anchor)}\s*", text[start:])
        start += found.end() if found else 0
    was = text[start:end]
    if node.kind in ("map", "list") and not node.flow:
        line = text.rfind("\n", 0, start) + 1
        if text[line:start].strip(" ") == "":  # a block below its key: after the key's colon
            head = text[:line].rstrip("\r\n")
            comment = re.search(r"\s+#[^\n]*$", head[head.rfind("\n") + 1 :])
            cut = len(head) - (len(comment[0]) if comment else 0)
            if head[:cut].rstrip().endswith(":"):
                return text[:cut] + " " + flow(value) + text[cut : len(head)] + text[end:]
    if node.kind == "scalar" and was[:1] in "|>" and was.endswith("\n"):
        ending = "\r\n" if was.endswith("\r\n") else "\n"
        return text[:start] + flow(value) + ending + text[end:]
    return text[:start] + flow(value, was) + text[end:]


def _inserted(text: str, node: Node, key: str, value: Any) -> str:
    """Put a new key at the end of a mapping."""
    entry = f"{flow(key)}: {flow(value)}"
    if node.flow:
        close = node.end - 1
        if not node.entries:
            return (
                text[: node.start]
                + re.sub(r"\{", "{" + entry, text[node.start : node.end], count=1)
                + (text[node.end :])
            )
        at = node.entries[-1][1].last()
        trailing = re.match(r"\s*,", text[at:close])
        at += trailing.end() if trailing else 0
        return text[:at] + ("" if trailing else ",") + f" {entry}" + text[at:]
    at = node.last()
    line = text.find("\n", max(at - 1, 0) if text[at - 1 : at] == "\n" else at)
    ending = "\r\n" if "\r\n" in text else "\n"
    indent = " " * node.column
    if line < 0:
        return text + ending + indent + entry
    return text[: line + 1] + indent + entry + ending + text[line + 1 :]


PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./ -]*")


def flow(value: Any, was: str = "") -> str:
    """A value as YAML on one line, a number in the manner of the one that it replaces."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "null"
    if isinstance(value, float):
        return _number(value, was)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{flow(k)}: {flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, str):
        said = value
        quote = was[:1] if was[:1] in ("'", '"') else ""
        if quote == "'" and "\n" not in said:
            return "'" + said.replace("'", "''") + "'"
        if not quote and PLAIN.fullmatch(said) and said == said.strip() and _reads_as(said, value):
            return said
        return json.dumps(value, ensure_ascii=False)
    return str(value)


def _reads_as(said: str, value: str) -> bool:
    try:
        return bool(YAML(typ="safe", pure=True).load(said) == value)
    except YAMLError:
        return False


def _number(value: float, was: str) -> str:
    """The shortest decimal that is this number, with an exponent where there was one."""
    if value != value:
        return ".nan"
    if value in (float("inf"), float("-inf")):
        return ".inf" if value > 0 else "-.inf"
    said = repr(value)
    if "e" in was.lower() and "e" not in said and value != 0.0:
        digits = f"{value:e}"
        for places in range(17):
            digits = f"{value:.{places}e}"
            if float(digits) == value:
                break
        said = digits
    if "e" in said:
        mantissa, exponent = said.split("e")
        if "." not in mantissa:
            mantissa += ".0"
        return f"{mantissa}e{int(exponent)}"
    return said
