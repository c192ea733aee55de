"""The page on flexsim_node names every parameter."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flexsim_node.service.settings import meanings

pytestmark = pytest.mark.ros
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "node.md").read_text()


def test_the_table_of_parameters() -> None:
    """The page names every parameter with its default and meaning."""
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*?)\|", PAGE, re.MULTILINE))
    for name, (default, _) in meanings().items():
        shown = rows[name].strip("` ")
        assert shown == (str(default).lower() if isinstance(default, bool) else str(default)), name
