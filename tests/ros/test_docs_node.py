"""What the pages on flexsim_node tell people to type starts a node."""

from __future__ import annotations

import re
import shlex
import signal
import sys
from pathlib import Path

import pytest
from processes import Background, ros_environment

from flexsim_node.settings import meanings

pytestmark = pytest.mark.ros
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "node.md").read_text()
PAGES = ["node", "lockstep", "ros2_control"]
LINES = [
    line
    for name in PAGES
    for block in re.findall(
        r"^```bash\n(.*?)^```", (ROOT / "docs" / f"{name}.md").read_text(), re.DOTALL | re.MULTILINE
    )
    for line in block.splitlines()
]


@pytest.mark.parametrize("line", LINES)
def test_commands(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    program, *words = shlex.split(line)
    assert program == "flexsim_node"
    start = [sys.executable, "-m", "flexsim_node.node", *words]
    node = Background(start, ros_environment(), tmp_path)
    node.wait_for("kernels ready", 180.0)
    assert node.end(signal.SIGINT) == 0


def test_the_table_of_parameters() -> None:
    """The page names every parameter with its default and meaning."""
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*?)\|", PAGE, re.MULTILINE))
    for name, (default, _) in meanings().items():
        shown = rows[name].strip("` ")
        assert shown == (str(default).lower() if isinstance(default, bool) else str(default)), name
