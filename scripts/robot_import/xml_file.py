"""XML read with its lines, and nothing in it that unfolds: a DOCTYPE is refused."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers.expat import ExpatError, ParserCreate

import numpy as np

LARGEST, DEEPEST = 32 * 2**20, 60  # bytes; elements in elements


class ImportRefused(ValueError):
    """A robot that can't be imported: FILE:LINE: what is wrong; what would be right."""


@dataclass
class Element:
    """An XML element: where it stands, what it holds."""

    tag: str
    attributes: dict[str, str]
    where: str
    children: list[Element] = field(default_factory=list)

    def all(self, tag: str) -> list[Element]:
        """The elements in it with this tag."""
        return [child for child in self.children if child.tag == tag]

    def one(self, tag: str) -> Element | None:
        """The element in it with this tag, or None; refuses several."""
        found = self.all(tag)
        if len(found) > 1:
            self.refuse(f"has {len(found)} <{tag}>; give one")
        return found[0] if found else None

    def text(self, name: str) -> str:
        """An attribute that must be there."""
        value = self.attributes.get(name, "").strip()
        if not value:
            self.refuse(f'has no {name}; give {name}="..."')
        return value

    def numbers(self, name: str, count: int, default: tuple[float, ...] | None = None) -> np.ndarray:
        """(count,) finite numbers of an attribute."""
        if name not in self.attributes and default is not None:
            return np.array(default)
        written = self.text(name)
        try:
            values = [float(word) for word in written.split()]
        except ValueError:
            values = []
        if len(values) != count or not np.all(np.isfinite(values)):
            right = "a finite number" if count == 1 else f"{count} finite numbers"
            self.refuse(f"has {name}={written[:60]!r}; give {right}")
        return np.array(values)

    def number(self, name: str, default: float | None = None) -> float:
        """A finite number of an attribute."""
        return float(self.numbers(name, 1, None if default is None else (default,))[0])

    def refuse(self, what: str) -> None:
        """Raise ImportRefused about this element."""
        name = self.attributes.get("name")
        raise ImportRefused(f"{self.where}: <{self.tag}{f' {name!r}' if name else ''}> {what}")


def read_xml(path: Path) -> Element:
    """The root element of a file.

    Raises
    ------
    ImportRefused
        where it is no file of a moderate size, no XML, or has a DOCTYPE
    """
    try:
        if not path.is_file():
            raise ImportRefused(f"{path}: no such file; give the path of a URDF or xacro file")
        if path.stat().st_size > LARGEST:
            raise ImportRefused(f"{path}: is larger than {LARGEST >> 20} MiB; give a robot's description")
        data = path.read_bytes()
    except OSError as problem:
        raise ImportRefused(f"{path}: can't be read ({problem.strerror}); give a URDF file") from None
    return parse_xml(data, str(path))


def parse_xml(data: bytes, source: str) -> Element:
    """The root element of an XML text; refusals name `source`."""
    parser = ParserCreate()
    opened: list[Element] = []
    roots: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, f"{source}:{parser.CurrentLineNumber}")
        if len(opened) >= DEEPEST:
            element.refuse(f"lies in {DEEPEST} others; give a robot's description")
        (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    def doctype(*_: object) -> None:
        raise ImportRefused(
            f"{source}:{parser.CurrentLineNumber}: has a DOCTYPE, whose entities may unfold without end;"
            " remove it: a URDF needs none"
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: opened.pop()
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except ExpatError as problem:
        reason = str(problem).split(":")[0]
        raise ImportRefused(f"{source}:{problem.lineno}: not XML: {reason}; give a URDF file") from None
    except (ValueError, LookupError) as problem:  # an encoding that Python has not, or can't be right
        if isinstance(problem, ImportRefused):
            raise
        raise ImportRefused(f"{source}: not XML: {problem}; give a URDF file in UTF-8") from None
    return roots[0]
