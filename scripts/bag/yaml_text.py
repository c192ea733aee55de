"""Writes plain data as YAML: mappings, lists, texts, numbers, truth values, nothing."""

from __future__ import annotations

from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.resolver import VersionedResolver


def dump(value: Any) -> str:
    """Return a value as lines of YAML's block style, in the order given."""
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False
    yaml.width = 1 << 16
    yaml.representer.ignore_aliases = lambda _: True
    # Readers of YAML 1.1 take an unquoted `on` for a truth value, and 12:30 for a number.
    yaml.Resolver = lambda version, loader: VersionedResolver(version=(1, 1), loader=loader)
    text = StringIO()
    yaml.dump(value, text)
    return text.getvalue()
