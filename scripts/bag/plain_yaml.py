"""Writes plain data as YAML: mappings, lists, texts, numbers, truth values, nothing."""

from __future__ import annotations

import json
import re
from typing import Any

# Words that no reader takes for anything but a text.
WORD = re.compile(r"(?!(?:null|true|false|yes|no|on|off|y|n)$)[A-Za-z][\w/.-]*\Z", re.IGNORECASE)


def dump(value: Any, indent: int = 0) -> str:
    """Return a value as lines of YAML's block style, each with its line break."""
    margin = " " * indent
    if isinstance(value, dict) and value:
        return "".join(f"{margin}{scalar(str(key))}:{behind(item, indent)}" for key, item in value.items())
    if isinstance(value, list) and value:
        # The first line of an item stands behind its dash.
        return "".join(f"{margin}- {dump(item, indent + 2).lstrip(' ')}" for item in value)
    return f"{margin}{scalar(value)}\n"


def behind(value: Any, indent: int) -> str:
    """Return what stands behind a key's colon."""
    if isinstance(value, (dict, list)) and value:
        return "\n" + dump(value, indent + 2 if isinstance(value, dict) else indent)
    return f" {scalar(value)}\n"


def scalar(value: Any) -> str:
    """Return a value of one line."""
    if isinstance(value, str) and WORD.match(value):
        return value
    if value is None or isinstance(value, (str, bool, int, float, dict, list)):
        return json.dumps(value, ensure_ascii=False)
    raise TypeError(f"{value!r} is not plain")
