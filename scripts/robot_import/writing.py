"""An imported scene as a file: YAML that a person reads and edits."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq


def scene_text(
    scene: dict[str, Any], source: str = "", units: str = "Lengths in m, angles in rad, masses in kg."
) -> str:
    """The YAML of a scene document; vectors and short mappings stand on one line.

    source : where it was imported from, or "" for nowhere
    """
    yaml = YAML()
    yaml.width = 120
    yaml.indent(mapping=2, sequence=4, offset=2)
    out = io.StringIO()
    yaml.dump(styled(scene, ()), out)
    origin = f"Imported from {' '.join(source.split())}. " if source else ""
    return f"# {origin}{units}\n{out.getvalue()}"


def styled(value: Any, path: tuple[str, ...]) -> Any:
    """The value in ruamel's kinds, what is small in flow style."""
    if isinstance(value, dict):
        found = CommentedMap({k: styled(v, (*path, k)) for k, v in value.items()})
        if path[-1:] and path[-1] in ("frame", "joint", "points", "position"):
            found.fa.set_flow_style()
        return found
    if isinstance(value, (list, tuple)):
        row = CommentedSeq([styled(v, path) for v in value])
        if not any(isinstance(v, dict) for v in value):
            row.fa.set_flow_style()
        return row
    return value


def write_whole(target: Path, text: str) -> None:
    """Write a file whole or not at all."""
    part = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
