"""What docs/thermal_node.md tells people to type starts a node."""

from __future__ import annotations

import re
import shlex
import signal
import sys
from pathlib import Path

import pytest
from processes import Background, ros_environment

from thermal_node.service.settings import meanings

pytestmark = pytest.mark.ros
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "thermal_node.md").read_text()
(BLOCK,) = re.findall(r"^```bash\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("line", BLOCK.splitlines())
def test_commands(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    program, *words = shlex.split(line)
    assert program == "thermal_node"
    start = [sys.executable, "-m", "thermal_node.node", *words]
    node = Background(start, ros_environment(), tmp_path)
    node.wait_for("kernels ready", 180.0)
    assert node.end(signal.SIGINT) == 0


def test_the_table_of_parameters() -> None:
    """The page names every parameter with its default."""
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*?)\|", PAGE, re.MULTILINE))
    for name, (default, _) in meanings().items():
        shown = rows[name].strip("` ")
        assert shown == (str(default).lower() if isinstance(default, bool) else str(default)), name
