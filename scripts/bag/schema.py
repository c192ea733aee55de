"""What a message of a type consists of, read from the definition that its bag carries: ros2msg or IDL."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from .definitions import full_name
from .errors import BagError

DTYPES = {
    "bool": "u1",
    "byte": "u1",
    "octet": "u1",
    "char": "u1",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}
TEXTS = {"string": 1, "wstring": 2}  # bytes a character
LINE = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?:\[(?P<bound><=)?(?P<size>\d*)\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<constant>=)?"
)
MSG, IDL = ("ros2msg",), ("ros2idl", "omgidl")
# Lines of IDL that say where another text begins, or include a file that is in the text already.
FILLER = "structure_needs_at_least_one_member"  # of a structure without any, in ROS's IDL
NOT_IDL = ("IDL: ", "=====", "#")


@dataclass(frozen=True)
class Member:
    """One field of a message: `size` None is a scalar, 0 a sequence, n an array of n."""

    name: str
    type: str
    size: int | None


Types = dict[str, list[Member]]


def types_of(root: str, encoding: str, text: str) -> Types:
    """Return the members of a type and of each that it depends on.

    Raises
    ------
    BagError
        The definition is in another language, can't be read, lacks a type, or contains itself.
    """
    if encoding in MSG:
        types = from_msg(root, text)
    elif encoding in IDL:
        types = from_idl(root, text)
    else:
        raise BagError(f"the definition of {root} is in '{encoding}', which is neither ros2msg nor IDL")
    check(root, types, (), set())
    return types


def from_msg(root: str, text: str) -> Types:
    """Read a ros2msg definition."""
    types: Types = {}
    for part in re.split(r"^={80}\n", text, flags=re.MULTILINE):
        head, _, body = part.partition("\n")
        name = root
        if head.startswith("MSG: "):
            name, part = full_name(head[5:].strip(), ""), body
        types[name] = [m for line in part.splitlines() if (m := member(line, name))]
    return types


def member(line: str, owner: str) -> Member | None:
    """Read one line of a message; comments and constants give None."""
    match = LINE.match(line.partition("#")[0].strip())
    if match is None or match["constant"]:
        return None
    kind = match["type"]
    if kind not in DTYPES and kind not in TEXTS:
        kind = full_name(kind, owner.partition("/")[0])
    if match["size"] is None:
        return Member(match["name"], kind, None)
    fixed = int(match["size"]) if match["size"] and not match["bound"] else 0
    return Member(match["name"], kind, fixed)


def from_idl(root: str, text: str) -> Types:
    """Read an IDL definition, by way of rosbags."""
    from rosbags.typesys import get_types_from_idl
    from rosbags.typesys.base import TypesysError

    plain = "\n".join(line for line in text.splitlines() if not line.startswith(NOT_IDL))
    try:
        found = get_types_from_idl(plain)
    except (
        TypesysError,
        ValueError,
        KeyError,
        TypeError,
        IndexError,
        AssertionError,
        RecursionError,
    ) as problem:
        said = str(problem).splitlines()
        raise BagError(
            f"the IDL of {root} can't be read: {said[0] if said else type(problem).__name__}"
        ) from None
    types = {name: [idl_member(n, d) for n, d in members] for name, (_, members) in found.items()}
    return {name: [m for m in members if m.name != FILLER] for name, members in types.items()}


def idl_member(name: str, described: Any) -> Member:
    """Return a member as rosbags describes it."""
    from rosbags.interfaces import Nodetype

    node, what = described
    size: int | None = None
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        (inner, what), count = what
        size = int(count) if node == Nodetype.ARRAY else 0
        node = inner
    return Member(name, str(what[0] if node == Nodetype.BASE else what), size)


def check(kind: str, types: Types, above: tuple[str, ...], sound: set[str]) -> None:
    """Raise BagError where a type is missing, or contains itself; `sound` gathers those that are not."""
    if kind in above:
        raise BagError(f"the definition of {above[0]} is no type: {kind} contains itself")
    if kind not in types:
        of = f" of {above[0]}" if above else ""
        raise BagError(f"the bag's definition{of} lacks {kind}")
    if len(above) > 50:
        raise BagError(f"the definition of {above[0]} is nested more than 50 deep")
    for inner in {m.type for m in types[kind]} - DTYPES.keys() - TEXTS.keys():
        if inner not in sound:
            check(inner, types, (*above, kind), sound)
    sound.add(kind)
