"""Every usual way of writing a log comes to the same seconds and degrees, or is refused with its place."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

from thermal_node.furnace.furnace import iso_834, read_log
from thermal_node.furnace.thermocouple_log import read_thermocouple_log

TIME = np.arange(0.0, 3601.0, 60.0)
HOT = iso_834(TIME)
COLD = 20.0 + 0.02 * TIME

TIMES = {
    "none": ("time", 1.0),
    "s": ("Time [s]", 1.0),
    "suffix": ("time_min", 60.0),
    "minutes": ("Elapsed (min)", 60.0),
    "german": ("Zeit in min", 60.0),
    "hours": ("Time / h", 3600.0),
    "comma": ("time, min", 60.0),
}
TEMPERATURES = {
    "none": ("{}", lambda v: v),
    "celsius": ("{} [°C]", lambda v: v),
    "fahrenheit": ("{} (°F)", lambda v: 1.8 * v + 32.0),
    "deg_f": ("{}_degF", lambda v: 1.8 * v + 32.0),
    "kelvin": ("{} / K", lambda v: v + 273.15),
    "slash_celsius": ("{} in °C", lambda v: v),
}
MARKS = {
    "comma": (",", "."),
    "semicolon": (";", "."),
    "tab": ("\t", "."),
    "german": (";", ","),
    "tabbed": ("\t", ","),
}
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "latin-1")


def written(time, temperature, mark, decimal, ends="\n", title=(), quoted=False):
    """A log's text: time, two furnace thermocouples, one on the leaf."""
    label, seconds = TIMES[time]
    name, of = TEMPERATURES[temperature]
    heads = [label, *(name.format(n) for n in ("furnace_1", "furnace_2", "tc_1"))]
    columns = [TIME / seconds, of(HOT - 5.0), of(HOT + 5.0), of(COLD)]

    def cell(text):
        return f'"{text}"' if quoted or mark in text else text

    lines = [*title, mark.join(cell(h) for h in heads)]
    lines += [
        mark.join(cell(f"{v:.6f}".replace(".", decimal)) for v in row) for row in zip(*columns, strict=True)
    ]
    return ends.join(lines) + ends


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_units_marks_and_encodings_in_every_combination(tmp_path, time, temperature):
    path = tmp_path / "log.csv"
    for (kind, (mark, decimal)), encoding in itertools.product(MARKS.items(), ENCODINGS):
        path.write_bytes(written(time, temperature, mark, decimal).encode(encoding))
        log = read_thermocouple_log(path)
        where = f"{kind}, {encoding}"
        np.testing.assert_allclose(log.time, TIME, atol=0.01, err_msg=where)
        np.testing.assert_allclose(log.furnace, HOT, atol=1e-3, err_msg=where)
        assert set(log.readings) == {"tc_1"}, where
        np.testing.assert_allclose(log.readings["tc_1"], COLD, atol=1e-3, err_msg=where)
        furnace = read_log(path, 60.0, "iso_834")
        assert len(furnace.names) == 2 and furnace(3600.0) == pytest.approx(HOT[-1], abs=1e-3), where


@pytest.mark.parametrize("seed", range(30))
def test_logs_written_at_random_are_read_right(tmp_path, seed):
    """Line ends, quotes, titles, empty lines, missing cells: what stands there is read."""
    chosen = random.Random(seed)
    kind = chosen.choice(list(MARKS))
    title = chosen.choice([(), ("Test 12",), ("Lab; hall 3", "", "door 4")])
    text = written(
        chosen.choice(list(TIMES)), chosen.choice(list(TEMPERATURES)), *MARKS[kind],
        ends=chosen.choice(["\n", "\r\n"]), title=title, quoted=chosen.random() < 0.3,
    )  # fmt: skip
    lines = text.split("\n")
    lost = len(title) + 1 + chosen.randrange(5, 50)
    mark = MARKS[kind][0]
    lines[lost] = mark.join([*lines[lost].rstrip("\r").split(mark)[:-1], ""])
    path = tmp_path / "log.csv"
    path.write_bytes("\n".join(lines).encode(chosen.choice(ENCODINGS)))
    log = read_thermocouple_log(path)
    missing = lost - len(title) - 1
    if not np.isnan(log.readings["tc_1"][missing]):
        pytest.fail(f"a cell that was missing was read as {log.readings['tc_1'][missing]}")
    kept = np.arange(len(TIME)) != missing
    np.testing.assert_allclose(log.readings["tc_1"][kept], COLD[kept], atol=1e-3)
    np.testing.assert_allclose(log.time, TIME, atol=0.01)


@pytest.mark.parametrize(("unit", "digits"), [("h", 4), ("h", 3), ("h", 6), ("min", 0), ("min", 2)])
def test_rows_of_a_minute_that_a_logger_rounded_are_no_gap(tmp_path, unit, digits):
    """0.0167 h is a minute, not 60.12 s, which a longest_gap of 60 s would refuse."""
    seconds = {"h": 3600.0, "min": 60.0}[unit]
    path = tmp_path / "log.csv"
    rows = [f"{t / seconds:.{digits}f},{v:.1f}" for t, v in zip(TIME, HOT, strict=True)]
    path.write_text(f"time [{unit}],furnace [°C]\n" + "\n".join(rows), encoding="utf-8")
    assert read_log(path, 60.0, "iso_834").time == pytest.approx(TIME, abs=1e-9)


def test_readings_that_cant_be_are_left_out_and_said(tmp_path):
    """A logger's fault codes and words; which, how many and where."""
    path = tmp_path / "log.csv"
    path.write_text("time,furnace,tc_1,tc_2\n0,20,20,20\n60,300,-9999,err\n120,400,3276.7,22\n180,500,25,-\n")
    log = read_thermocouple_log(path)
    np.testing.assert_array_equal(np.isnan(log.readings["tc_1"]), [False, True, True, False])
    notes = " | ".join(log.notes)
    assert "tc_1: 2 readings beyond -100 to 1400 °C were left out, the first -9999 °C at 60 s" in notes
    assert "tc_2: cells that are no number were left out, 1 of them, the first in line 3: 'err'" in notes
    assert "without a unit, so read as s or °C: time, furnace, tc_1, tc_2" in notes


def test_letters_that_number_a_series_are_no_units(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,tc_a,tc_b,tc_c,tc_f\n0,20,20,20,20\n60,21,22,23,24\n")
    log = read_thermocouple_log(path)
    assert list(log.readings) == ["tc_a", "tc_b", "tc_c", "tc_f"]
    assert log.readings["tc_f"][1] == 24.0
    path.write_text("time,tc_1_f\n0,68\n60,212\n")
    assert read_thermocouple_log(path).readings["tc_1"] == pytest.approx([20.0, 100.0])
