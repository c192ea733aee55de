"""Torques come in as Excel, PlotJuggler, pandas and MATLAB write them, and signals go out for these."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_kinds import T0, by_mcap, run
from flexsim.bag import Bag
from flexsim.signals.torque import read_torque
from processes import flexsim_here

ROWS = [(0.01 * k, 0.1 * k, -0.05 * k) for k in range(6)]
JOINTS = ("joint_1", "joint_2")
EPOCH = 1_780_000_000
# What in force is at 0, 1, ... ms, up to 59 ms.
WANTED = np.array([[0.1 * (k // 10), -0.05 * (k // 10)] for k in range(60)])


def lines(head: str, mark: str = ",", start: float = 0.0) -> str:
    body = "".join(f"{start + t:.9f}{mark}{a}{mark}{b}\n" for t, a, b in ROWS)
    return f"{head}\n{body}" if head else body


HEAD = "t,joint_1,joint_2"
PATHS = "__time,/joint_states/joint_1/effort,/joint_states/joint_2/effort"
# Files by the tool that writes them so.
READ: dict[str, bytes] = {
    "ours": lines(HEAD).encode(),
    "no names": lines("").encode(),
    "Excel with its mark": lines(HEAD).replace("\n", "\r\n").encode("utf-8-sig"),
    "Excel in Unicode": lines("t\tjoint_1\tjoint_2", "\t").encode("utf-16"),
    "UTF-16 without a mark": lines(HEAD).encode("utf-16-le"),
    "German Excel": lines("t;joint_1;joint_2", ";").replace(".", ",").encode("cp1252"),
    "Excel's sep": ("sep=;\n" + lines("t;joint_1;joint_2", ";")).encode(),
    "PlotJuggler": lines(PATHS, start=EPOCH).encode(),
    "a list of numbers": lines("time,/flexsim_node/commands/data[0],/flexsim_node/commands/data[1]").encode(),
    "pandas": lines(",joint_1,joint_2").encode(),
    "pandas with dates": ("timestamp,joint_1,joint_2\n" + "".join(
        f"2026-05-28 20:26:40.{round(1e6 * t):06d},{a},{b}\n" for t, a, b in ROWS)).encode(),
    "milliseconds": ("t_ms,joint_1,joint_2\n" + "".join(
        f"{1e3 * t:g},{a},{b}\n" for t, a, b in ROWS)).encode(),
    "nanoseconds of the wall": ("stamp,joint_1,joint_2\n" + "".join(
        f"{EPOCH * 10**9 + round(1e9 * t)},{a},{b}\n" for t, a, b in ROWS)).encode(),
    "MATLAB": lines("Time,joint_1 (Nm),joint_2 (Nm)").encode(),
    "columns parted by spaces": lines("t joint_1 joint_2", "  ").encode(),
    "a comment, quotes and spaces": ('# of the scope\n"t", "joint_2", "joint_1"\n' + "".join(
        f"{t}, {b}, {a}\n" for t, a, b in ROWS)).encode(),
    "empty cells hold": (PATHS + "\n" + "".join(
        f"{t},{a},\n{t + 0.0005},,{b}\n" for t, a, b in ROWS)).encode(),
    "a column more": ("t,joint_1,joint_2,temperature,/joint_states/joint_1/position\n" + "".join(
        f"{t},{a},{b},20,1\n" for t, a, b in ROWS)).encode(),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("tool", READ)
def test_torques_as_other_tools_write_them(tool: str, tmp_path: Path) -> None:
    """Each row comes into force at its time, whatever the file looks like."""
    file = tmp_path / "torque.csv"
    file.write_bytes(READ[tool])
    found = read_torque(file, JOINTS, (), 60, 1e-3)
    wanted = WANTED.copy()
    if tool == "empty cells hold":
        found, wanted = found[np.arange(60) % 10 != 0], wanted[np.arange(60) % 10 != 0]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-15)


def test_the_clock_on_the_wall_is_said_and_shifted(tmp_path: Path) -> None:
    """Epoch times begin the run at their first, which is said, or at --start: never silently no torque."""
    file = tmp_path / "torque.csv"
    file.write_text(lines(PATHS, start=EPOCH))
    with pytest.warns(UserWarning, match=r"wall's clock; the run begins at its first, 1780000000\.000"):
        read_torque(file, JOINTS, (), 60, 1e-3)
    found = read_torque(file, JOINTS, (), 30, 1e-3, start=EPOCH + 0.02)
    np.testing.assert_array_equal(found, WANTED[20:50])
    with pytest.raises(ValueError, match="it drives nothing"):
        read_torque(file, JOINTS, (), 60, 1e-3, start=0.0)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "holds no rows"),
        (HEAD + "\n", "holds a header, t, joint_1, joint_2, and no rows"),
        ("t,joint_1\n0,1\n", "no column is of joint_2"),
        ("x,joint_1,joint_2\n0,1,2\n", "none is t or time"),
        (HEAD + "\n0,1,2\n0,1,2\n", "line 3: t does not rise"),
        (HEAD + "\n0,1,two\n", "line 2: 'two' is no number"),
        (HEAD + "\n0,1,inf\n", "line 2: the torque of joint_2 is not finite"),
        (HEAD + "\n,1,2\n", "line 2: there is no time"),
        (HEAD + "\n0,1,2,3\n", "line 2: 4 cells where 3 columns are"),
        (HEAD + ",/joint_states/joint_1/effort\n0,1,2,3\n", "are both of joint_1"),
        ("1780000000,10,,joint_1,joint_2,0.0,0.1\n", "7 columns without names"),
    ],
)
def test_refused_with_file_and_reason(text: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "torque.csv"
    file.write_text(text)
    with pytest.raises(ValueError, match=r"torque\.csv") as told:
        read_torque(file, JOINTS, (), 60, 1e-3)
    assert sentence in str(told.value)


def flexsim(*words: Any) -> Any:
    return flexsim_here(*words, cwd=Path.cwd())


def test_signals_go_out_and_come_back(tmp_path: Path) -> None:
    """CSV, Parquet and NumPy hold each message to the bit, and a robot can be driven by what was exported."""
    from pyarrow import parquet

    rows = [r for r in run(20, clock=0) if r.topic == "/joint_states" and len(r.message.name) == 3]
    path = by_mcap(tmp_path / "run.mcap", rows)
    for name in ("joints.csv", "joints.parquet", "joints.npz"):
        done = flexsim("export", path, "/joint_states", "-o", tmp_path / name)
        assert done.returncode == 0, done.stderr
    position = Bag(path).array("/joint_states", "position")[1]
    arrow, saved = parquet.read_table(tmp_path / "joints.parquet"), np.load(tmp_path / "joints.npz")
    with (tmp_path / "joints.csv").open() as file:
        table = list(csv.DictReader(file))
    for k, joint in enumerate("abc"):
        column = np.array([float(row[f"{joint}/position"]) for row in table])
        np.testing.assert_array_equal(column, position[:, k])
        np.testing.assert_array_equal(arrow[f"{joint}/position"], column)
        np.testing.assert_array_equal(saved[f"joint_states/{joint}/position"], column)
    assert table[1]["t"] == "0.020000000" and table[0]["received"] == f"{T0 // 10**9}.000000000"
    with pytest.warns(UserWarning, match="not used: received"):
        torque = read_torque(tmp_path / "joints.csv", ("a", "b", "c"), (), 150, 1e-3)
    np.testing.assert_array_equal(torque[10], 0.1 * position[0])
    np.testing.assert_array_equal(torque[149], 0.1 * position[13])


def test_a_folder_of_all_topics(tmp_path: Path) -> None:
    """Lists of any length, text and several sets of joints find their columns."""
    path = by_mcap(tmp_path / "run.mcap", run(8))
    done = flexsim("export", path, "-o", tmp_path / "tables", "--json")
    told = json.loads(done.stdout)
    assert {what["topic"]: what["rows"] for what in told["files"].values()} == {
        "/joint_states": 16, "/path": 8, "/tf": 8, "/arm/commands": 8, "/said": 8, "/stop": 8, "/cell": 8,
    }  # fmt: skip
    with (tmp_path / "tables" / "path.csv").open() as file:
        poses = list(csv.DictReader(file))
    assert poses[3]["poses.header.frame_id[2]"] == "map2" and poses[3]["poses.header.frame_id[3]"] == ""
    with (tmp_path / "tables" / "joint_states.csv").open() as file:
        joints = list(csv.DictReader(file))
    assert joints[1]["a/position"] == "" and joints[1]["finger/position"] == "0.0"
    again = flexsim("export", path, "-o", tmp_path / "tables")
    assert again.returncode == 1 and "exists already" in again.stderr
    assert flexsim("export", path, "-o", tmp_path / "all.csv").returncode == 2
