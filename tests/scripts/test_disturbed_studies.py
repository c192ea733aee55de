"""A study that is killed, changed, damaged or begun twice ends as an undisturbed one, or says why not."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import command, ros_environment

SCENE = """model: robot
name: tiny
gravity: [0.0, -9.81, 0.0]
damping: {beta: 1.0e-4}
links:
  - name: a
    dh: {a: 0.5}
    joint: {name: j1}
    beam: {width: 0.005, depth: 0.02, density: 7800.0, youngs_modulus: 2.0e11, elements: 2}
solver: {step: 1.0e-3}
"""
OTHER = SCENE.replace("a: 0.5", "a: 0.6")
WORDS = ("accuracy", "tiny.yaml", "--quick", "-d", "0.03", "--tolerance", "0.1mm", "-o", "out", "--json")
KINDS = ("killed", "interrupted", "changed", "begun twice", "cut", "damaged", "reference gone")
PATIENCE = 1800.0  # kernels may have to be compiled first
# What a study says where it does not go on.
REASONS = ("another study works here", "has changed since it began", "damaged", "does not fit")
NIGHTLY = 100


def begin(folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(command(*WORDS), cwd=folder, env=ros_environment(), text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    said, errors = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in errors, errors
    return process.returncode, said, errors


def errors_of(said: str) -> dict[str, Any]:
    """Each point's status and errors: times are the machine's, these are not."""
    return {p["point"]: (p["status"], p["errors"]) for p in json.loads(said)["points"]}


def undisturbed(folder: Path, scene: str = SCENE) -> tuple[dict[str, Any], float]:
    """What such a study finds, and how long it takes, s."""
    folder.mkdir()
    (folder / "tiny.yaml").write_text(scene)
    began = time.monotonic()
    code, said, errors = ended(begin(folder))
    assert code == 0, errors
    return errors_of(said), time.monotonic() - began


def spoil(kind: str, folder: Path, study: subprocess.Popen[str], random: np.random.Generator) -> None:
    """Do what is to be done while a study runs, or to what a killed one has left."""
    points = folder / "out" / "points.jsonl"
    if kind == "interrupted":
        study.send_signal(signal.SIGINT)
    elif kind == "changed":
        (folder / "tiny.yaml").write_text(OTHER)
    elif kind == "begun twice":
        code, _, errors = ended(begin(folder))
        alone = study.poll() is not None  # the first one had ended
        assert code == 0 if alone else "another study works here" in errors or code == 0, errors
    else:
        study.send_signal(signal.SIGKILL)
        study.wait()
        data = points.read_bytes() if points.exists() else b""
        if kind == "cut" and data:
            points.write_bytes(data[: int(random.integers(0, len(data)))])
        elif kind == "damaged" and data:
            at = int(random.integers(0, len(data)))
            points.write_bytes(data[:at] + bytes([data[at] ^ 0x10]) + data[at + 1 :])
        elif kind == "reference gone":
            (folder / "out" / "reference.npz").unlink(missing_ok=True)


def disturbed(seed: int, folder: Path, right: dict[str, Any], other: dict[str, Any], takes: float) -> str:
    """Disturb one study at a random time and go on with it; "" where it ends right or says why it does not.

    right, other : figures of the scene, and of the one that its file is changed to
    """
    random = np.random.default_rng([23, seed])
    kind = KINDS[seed % len(KINDS)]
    folder.mkdir()
    file = folder / "tiny.yaml"
    file.write_text(SCENE)
    study = begin(folder)
    time.sleep(float(random.uniform(0.0, takes)))
    spoil(kind, folder, study, random)
    # A file that is changed before the study has read it is the one that is studied.
    wrong = judged(study, [right, other] if kind == "changed" else [right])
    if kind == "changed":
        wrong = wrong or judged(begin(folder), [other])
        file.write_text(SCENE)
    wrong = wrong or judged(begin(folder), [right])
    return f"{kind}: {wrong}" if wrong else ""


def judged(study: subprocess.Popen[str], right: list[dict[str, Any]]) -> str:
    """What is wrong with how a study ended; a signal's exit codes say why themselves."""
    code, said, errors = ended(study)
    if code == 0:
        return "" if errors_of(said) in right else "ended with other figures"
    if code in (130, -signal.SIGKILL) or any(reason in errors for reason in REASONS):
        return ""
    return f"exit code {code}: {errors!r}"


@pytest.mark.slow
def test_a_killed_study_goes_on(tmp_path: Path) -> None:
    right, takes = undisturbed(tmp_path / "right")
    assert disturbed(0, tmp_path / "killed", right, {}, takes) == ""


@pytest.mark.nightly
def test_a_hundred_disturbed_studies(tmp_path: Path) -> None:
    right, takes = undisturbed(tmp_path / "right")
    other, _ = undisturbed(tmp_path / "other", OTHER)
    assert other != right
    found = {seed: disturbed(seed, tmp_path / str(seed), right, other, takes) for seed in range(NIGHTLY)}
    assert {seed: wrong for seed, wrong in found.items() if wrong} == {}
