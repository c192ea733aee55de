"""What docs/bags.md tells people to type does what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from processes import Recorded, flexsim

pytestmark = pytest.mark.ros

PAGE = Path(__file__).parents[2] / "docs" / "bags.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)


def test_commands(recorded: Recorded, tmp_path: Path) -> None:
    (tmp_path / "run").symlink_to(recorded.bag)
    lines = [shlex.split(line, comments=True) for block in blocks("bash") for line in
             block.splitlines()]  # fmt: skip
    # What needs a robot to drive is run by tests/ros/test_play.py.
    once_more = [words for words in lines if "again" in words or "again.npz" in words]
    assert [words[1] for words in once_more] == ["play", "compare", "simulate"]
    lines = [words for words in lines if words not in once_more]
    assert len(lines) == 10
    for number, (program, verb, *words) in enumerate(lines):
        assert program == "flexsim"
        if verb == "record":  # elsewhere, and not for as long
            words = [w for w in words if w not in ("--duration", "60")]
            words[words.index("run")] = f"run_{number}"
            words += ["--duration", "0.2"]
        if "--web" in words:  # shown until Ctrl-C
            words += ["--duration", "1"]
        done = flexsim(verb, *words, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "run.rrd").stat().st_size > 100_000
    assert (tmp_path / "run_0" / "metadata.yaml").exists()


def test_python(recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "run").symlink_to(recorded.bag)
    monkeypatch.chdir(tmp_path)
    (program,) = blocks("python")
    names: dict[str, object] = {}
    exec(program, names)
    assert len(names["t"]) == recorded.messages  # type: ignore[arg-type]
    assert names["position"].shape == (recorded.messages, 3)  # type: ignore[attr-defined]
