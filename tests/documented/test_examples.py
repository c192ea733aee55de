"""Every documented example does what it says, as it stands: README.md, docs/*.md, and each verb's --help."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import circumstances
import extract
import pytest
from circumstances import A_BURNT_DOOR, LONG_PROGRAMS, NOT_RUN, RUN_BY_THE_TEST, Example
from inputs import furnace_log, prepare, recorded_robot
from processes import ros_environment

pytestmark = [pytest.mark.ros, pytest.mark.slow]
SHORT, LONG = 240.0, 7200.0  # s after which an example hangs; beside others it may take long


def marked(keys: dict[str, Example]) -> list[object]:
    return [pytest.param(key, marks=pytest.mark.nightly if keys[key].nightly else ()) for key in keys]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_robot(tmp_path_factory.mktemp("recorded"))


def shell(
    line: str, folder: Path, environment: dict[str, str] | None = None, output: str = "out.txt"
) -> subprocess.Popen[str]:
    """Start a line as a shell with this environment's programs does."""
    environment = environment or ros_environment()
    path = f"{Path(sys.executable).parent}:{environment['PATH']}"
    with (folder / output).open("w") as out:
        return subprocess.Popen(
            ["bash", "-c", f"exec {line}"], cwd=folder, env=environment | {"PATH": path}, stdout=out,
            stderr=subprocess.STDOUT, text=True, start_new_session=True,
        )  # fmt: skip


def said(folder: Path) -> str:
    return (folder / "out.txt").read_text(errors="replace")


def finish(process: subprocess.Popen[str], timeout: float) -> int:
    """Wait for the end of a process, and leave none behind."""
    try:
        return process.wait(timeout)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def test_every_example_is_run_or_says_why_not() -> None:
    """A new example of the documentation must be run here; one that is gone from there is gone from here."""
    documented = extract.commands()
    known = {*RUN_BY_THE_TEST, *A_BURNT_DOOR}
    forgotten = [c for c in documented if c not in known and not c.startswith(tuple(NOT_RUN))]
    assert not forgotten, f"add them to tests/documented/circumstances.py: {forgotten}"
    assert not [c for c in known if c not in documented]
    assert not [start for start in NOT_RUN if not any(c.startswith(start) for c in documented)]
    assert not [c for c in known if c.startswith(tuple(NOT_RUN))]


def test_the_extractor_finds_what_is_new(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """In a block, indented, inline, behind a backslash; and not what only shows how a command is built."""
    page = tmp_path / "page.md"
    page.write_text(
        "# A page\n\n```bash\nflexsim info new  # a comment\nflexsim view new \\\n    --web\n```\n\n"
        "    flexsim recover new\n    a = b\n\n"
        "Type `flexsim report new`, as `flexsim report BAG`, `flexsim info`.\n"
        "\n    from flexsim.bag import Bag\n    Bag('new')\n\n```python\nx = 1\n```\n"
    )
    monkeypatch.setattr(extract, "PAGES", [page])
    found = [command for command, _ in extract.on_pages()]
    assert [c.partition("  #")[0] for c in found] == [
        "flexsim info new", "flexsim view new --web", "flexsim recover new", "flexsim report new",
    ]  # fmt: skip
    assert extract.programs() == {"page.md": "x = 1\n\nfrom flexsim.bag import Bag\nBag('new')\n"}


@pytest.mark.parametrize("line", marked(RUN_BY_THE_TEST))
def test_command(line: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """It ends with exit code 0, by itself or, where it has no end of its own, at Ctrl-C."""
    example = RUN_BY_THE_TEST[line]
    recorded = request.getfixturevalue("bag") if {"run", "again"} & set(example.needs) else None
    prepare(example.needs, tmp_path, recorded)
    timeout = LONG if example.nightly else SHORT
    process = shell(line, tmp_path)
    if example.until:
        end = time.monotonic() + timeout
        while example.until not in said(tmp_path) and process.poll() is None and time.monotonic() < end:
            time.sleep(0.05)
        assert example.until in said(tmp_path), said(tmp_path)
        process.send_signal(signal.SIGINT)
    assert finish(process, timeout) == 0, said(tmp_path)
    assert "Traceback" not in said(tmp_path)
    for name in example.makes:
        assert (tmp_path / name).stat().st_size > 0, name


@pytest.mark.nightly
def test_a_burnt_door(tmp_path: Path) -> None:
    """docs/thermal_node.md records a fire; the furnace that was recorded burns another door."""
    prepare((), tmp_path, None)
    record, fire, again = A_BURNT_DOOR
    environment = ros_environment()  # of both: one hears the other
    recorder = shell(record.removesuffix(" &"), tmp_path, environment, "recorder.txt")
    door = shell(fire, tmp_path, environment)
    end = time.monotonic() + LONG
    while "ended at 3600 s" not in said(tmp_path) and door.poll() is None and time.monotonic() < end:
        time.sleep(0.5)
    for process in (door, recorder):
        process.send_signal(signal.SIGINT)
        assert finish(process, SHORT) == 0, said(tmp_path)
    assert finish(shell(again, tmp_path), LONG) == 0, said(tmp_path)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.nightly if page in LONG_PROGRAMS else ())
        for page in extract.programs()
    ],
)
def test_python(page: str, bag: Path, tmp_path: Path) -> None:
    """The Python of a page, from its first block to its last, runs as one program."""
    prepare(("run",), tmp_path, bag)
    if "log.csv" in extract.programs()[page]:
        furnace_log(tmp_path)
    (tmp_path / "page.py").write_text(extract.programs()[page])
    process = shell("python page.py", tmp_path)
    assert finish(process, LONG if page in LONG_PROGRAMS else SHORT) == 0, said(tmp_path)


def test_long_programs_are_there() -> None:
    assert set(circumstances.LONG_PROGRAMS) <= set(extract.programs())
