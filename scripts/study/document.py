"""A scene's file as it is read once, for all runs of a study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ruamel.yaml import YAML


def read_document(path: str | Path) -> dict[str, Any]:
    """What a scene's file says, in dicts and lists; the scene's reader has accepted it before."""
    found: dict[str, Any] = YAML(typ="safe", pure=True).load(Path(path).read_text(encoding="utf-8"))
    return found
