"""The set-up: what `make` promises a person who has Python, a compiler and make."""

import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[1]
RUNTIME, TEST = ROOT / "requirements.lock", ROOT / "requirements-test.lock"
DOCS = ROOT / "requirements-docs.lock"


def pins(*locks: Path) -> list[Requirement]:
    """Return the requirements of lock files, without their hashes."""
    lines = "".join(lock.read_text() for lock in locks).replace("\\\n", "").splitlines()
    return [Requirement(line.split("--hash")[0]) for line in lines]


def make(*arguments: str, cwd: Path = ROOT, **environment: str) -> subprocess.CompletedProcess:
    """Run make as a person would, whatever make started these tests."""
    inherited = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "PYTHON"))}
    return subprocess.run(
        ["make", *arguments],
        cwd=cwd,
        env=inherited | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout in which nothing is set up, in a folder with a space in its name."""
    folder = tmp_path / "a checkout"
    shutil.copytree(ROOT / "msgs_schema", folder / "msgs_schema")
    for name in ("Makefile", "pyproject.toml", RUNTIME.name, TEST.name):
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.mark.parametrize("lock", [RUNTIME, TEST, DOCS], ids=lambda lock: lock.name)
def test_every_line_of_a_lock_is_one_version_with_its_hashes(lock: Path) -> None:
    for pin in pins(lock):
        assert [s.operator for s in pin.specifier] == ["=="], pin
    entries = re.split(r"\n(?! )", lock.read_text().strip())
    assert not [entry for entry in entries if "--hash=sha256:" not in entry]


@pytest.mark.parametrize("python", ["3.10", "3.11", "3.12", "3.13"])
def test_the_locks_hold_what_pyproject_asks_for_on_every_python(python: str) -> None:
    here = {"python_version": python, "python_full_version": f"{python}.0", "extra": ""}
    pinned: dict[str, Version] = {}
    for pin in pins(RUNTIME, TEST):
        if pin.marker is None or pin.marker.evaluate(here):
            name = canonicalize_name(pin.name)
            assert name not in pinned, f"{name} is pinned twice for Python {python}"
            pinned[name] = Version(next(iter(pin.specifier)).version)
    asked = [Requirement(line) for line in requires("flexsim") or []]
    assert len(asked) > 20
    for extra in ("", "messages", "test"):
        for requirement in asked:
            if requirement.marker is None or requirement.marker.evaluate(here | {"extra": extra}):
                version = pinned[canonicalize_name(requirement.name)]
                assert version in requirement.specifier, requirement


@pytest.mark.parametrize("python", ["3.10", "3.11", "3.12", "3.13"])
def test_the_sites_lock_holds_what_its_group_asks_for(python: str) -> None:
    """It stands by itself: the site's builder is installed beside the virtual environment."""
    here = {"python_version": python, "python_full_version": f"{python}.0"}
    pinned = {
        canonicalize_name(pin.name): Version(next(iter(pin.specifier)).version)
        for pin in pins(DOCS)
        if pin.marker is None or pin.marker.evaluate(here)
    }
    group = re.search(r"^docs = (\[.+\])$", (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert group
    for requirement in map(Requirement, ast.literal_eval(group[1])):
        assert pinned[canonicalize_name(requirement.name)] in requirement.specifier


def test_a_wheel_holds_every_file_and_nothing_named_scripts(tmp_path: Path) -> None:
    source = tmp_path / "source"
    for folder in (
        "flexsim_node",
        "thermal_node",
        "scripts",
        "msgs_schema/flexsim_core",
        "msgs_schema/flexsim_ros",
    ):
        shutil.copytree(ROOT / folder, source / folder)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    command += ["--no-build-isolation", "--wheel-dir", str(tmp_path), str(source)]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(next(tmp_path.glob("flexsim-*.whl"))) as wheel:
        held = {name for name in wheel.namelist() if name.endswith((".py", "py.typed"))}
    found = [*source.rglob("*.py"), *source.rglob("py.typed")]
    files = (path.relative_to(source) for path in found if "build" not in path.parts)
    places = {r"^scripts/": "flexsim/", r"^msgs_schema/": ""}
    wanted = {str(path) for path in files}
    for folder, place in places.items():
        wanted = {re.sub(folder, place, path) for path in wanted}
    assert held == wanted
    packages = ("flexsim", "flexsim_core", "flexsim_node", "flexsim_ros", "thermal_node")
    assert {f"{name}/py.typed" for name in packages} <= held  # so that a user's type checker looks into them


def test_the_change_log_knows_this_version() -> None:
    version = re.search(r'^version = "(.+)"', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert version and f"\n## {version[1]}" in (ROOT / "CHANGELOG.md").read_text()


def test_a_second_make_has_nothing_to_set_up() -> None:
    if Path(sys.prefix) != ROOT / ".venv":
        pytest.skip("these tests do not run in the venv that make builds")
    assert "Nothing to be done" in make("-n", "setup").stdout


def test_an_interrupted_set_up_is_begun_again(checkout: Path) -> None:
    (checkout / ".venv/bin").mkdir(parents=True)
    assert "-m venv .venv" in make("-n", "setup", cwd=checkout).stdout


def test_a_checkout_that_was_moved_is_set_up_again(checkout: Path) -> None:
    stamps = checkout / ".venv/stamps"
    stamps.mkdir(parents=True)
    for name in ("venv", "standard", "messages", "project", "kernels"):
        (stamps / name).touch()
    (stamps / "place").write_text(f"{checkout.resolve()}\n")
    assert "Nothing to be done" in make("-n", "setup", cwd=checkout).stdout
    (stamps / "place").write_text("/elsewhere\n")
    assert "-m venv .venv" in make("-n", "setup", cwd=checkout).stdout


def test_a_python_that_is_too_old_is_refused_in_one_line(checkout: Path) -> None:
    old = checkout / "python3.9"
    old.write_text('#!/bin/sh\n[ "$1" = --version ] && echo Python 3.9.18\nexit 1\n')
    old.chmod(0o755)
    result = make("setup", cwd=checkout, PYTHON=str(old))
    assert result.returncode != 0
    first, *rest = result.stderr.splitlines()
    assert first.startswith("flexsim needs Python 3.10 to 3.13;") and "Python 3.9.18" in first
    assert len(rest) == 1  # make's own word that it stopped
    assert not (checkout / ".venv").exists()


def test_no_compiler_is_said_in_one_line(checkout: Path) -> None:
    result = make("setup", cwd=checkout, PYTHON=sys.executable, CXX="no-such-compiler")
    assert result.returncode != 0
    assert "needs a C and C++ compiler, no-such-compiler is not there" in result.stderr
    assert not (checkout / ".venv").exists()
