"""What is written as YAML is read by others as it was: texts stay texts, in YAML 1.1 as in 1.2."""

from __future__ import annotations

from typing import Any

import pytest
import yaml as yaml_1_1
from flexsim.bag.yaml_text import dump
from ruamel.yaml import YAML

TEXTS = [
    "", " ", "on", "No", "y", "~", "null", "1e5", "0x1", "1_0", "12:30:00", "2001-01-01", "=", "<<", "- a",
    "a: b", "# a", "a\nb\n\n c", "\t", "a\r\nb", "it's", '"', "é😀\u2028", "\x1b[2J\0\x85", "word " * 100,
]  # fmt: skip
SHARED = {"sec": 9223372036, "nsec": 854775807}


@pytest.mark.parametrize(
    "value",
    [
        {text: [text] for text in TEXTS},
        {
            "z": 2**63,
            "a": -1,
            "f": 1.5,
            "t": True,
            "n": None,
            "list": [],
            "map": {},
            "deep": [[1], {"a": [{}]}],
        },
        [SHARED, SHARED],
    ],
    ids=["texts", "values", "shared"],
)
def test_others_read_what_was_written(value: Any) -> None:
    """PyYAML (1.1) and ruamel.yaml (1.2) agree, and the order is kept."""
    text = dump(value)
    assert yaml_1_1.safe_load(text) == YAML(typ="safe", pure=True).load(text) == value
    assert "&" not in text and list(value) == list(YAML(typ="safe", pure=True).load(text))
