"""docs/accuracy.md is what its command makes of the kept studies, and its commands are those of the verb."""

from __future__ import annotations

import json
import re
import shlex
import sys
from pathlib import Path

from click.testing import CliRunner
from flexsim.study.choice import frontier
from flexsim.verbs.accuracy import command

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "accuracy.md"
sys.path.insert(0, str(ROOT / "benchmarks"))


def test_the_commands_are_understood() -> None:
    """Every command is parsed by the verb itself; each scene exists."""
    blocks = re.findall(r"^```bash\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    lines = [shlex.split(line) for block in blocks for line in block.splitlines()]
    assert len(lines) == 3
    for program, verb, scene, *words in lines:
        assert (program, verb) == ("flexsim", "accuracy")
        assert (ROOT / scene).is_file()
        context = command.make_context("accuracy", [scene, *words])
        assert context.params["scene"] == scene
    assert "Example:" in CliRunner().invoke(command, ["--help"]).output


def test_the_page_says_what_the_studies_found() -> None:
    """Each kept study's sentence and frontier stand on the page; each reference is good enough."""
    from accuracy_page import STUDIES, outcomes_of

    page = PAGE.read_text()
    kept = [path for path in (ROOT / "docs" / "accuracy").glob("*.json") if path.stem in STUDIES]
    assert kept
    for path in kept:
        study = json.loads(path.read_text())
        assert study["sentence"] in page, path
        main = next(iter(study["measures"]))
        floor = 10.0 * study["reference"]["error"][main]
        best = frontier(outcomes_of(study), main, floor)
        assert [o.point for o in best] == study["frontier"]
        assert all(o.error(main) >= floor for o in best[:-1]), path
        assert (ROOT / "docs" / "images" / f"accuracy_{path.stem}.png").read_bytes()[:4] == b"\x89PNG"
