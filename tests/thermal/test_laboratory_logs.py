"""Logs as laboratories write them are read right, or refused with the file, the place and the remedy."""

from __future__ import annotations

import numpy as np
import pytest

from thermal_node import SceneError
from thermal_node.furnace.furnace import iso_834, read_log
from thermal_node.furnace.thermocouple_log import read_thermocouple_log

TIME = np.arange(0.0, 3601.0, 30.0)
HOT = iso_834(TIME)


def rows(*columns, mark=","):
    return "\n".join(mark.join(str(v) for v in row) for row in zip(*columns, strict=True))


def clock(seconds):
    return [f"{int(s) // 3600}:{int(s) % 3600 // 60:02d}:{int(s) % 60:02d}" for s in seconds]


READ = {
    "several_columns": ("time,furnace_1,furnace_2\n" + rows(TIME, HOT - 60, HOT + 60), "utf-8", 2),
    "ambient_first": ("time,temp_ambient,temp_furnace\n" + rows(TIME, 0 * HOT + 20, HOT), "utf-8", 1),
    "set_point_beside": ("time,furnace set,furnace\n" + rows(TIME, 0 * HOT, HOT), "utf-8", 1),
    "mean_beside": ("time,furnace mean,furnace 1,furnace 2\n" + rows(TIME, 0 * HOT, HOT, HOT), "utf-8", 2),
    "byte_order_mark": ("\ufefftime,temperature\n" + rows(TIME, HOT), "utf-8", 1),
    "utf_16": ("time,temperature\n" + rows(TIME, HOT), "utf-16", 1),
    "latin_1": ("time,temperature °C\n" + rows(TIME, HOT), "latin-1", 1),
    "minutes": ("time_min,furnace\n" + rows(TIME / 60, HOT), "utf-8", 1),
    "hours": ("Time [h],furnace\n" + rows(TIME / 3600, HOT), "utf-8", 1),
    "clock": ("Time,Furnace TC1,O2\n" + rows(clock(TIME), HOT, 0 * HOT), "utf-8", 1),
    "fahrenheit": ("time,furnace_f\n" + rows(TIME, 1.8 * HOT + 32), "utf-8", 1),
    "kelvin": ("time,furnace [K]\n" + rows(TIME, HOT + 273.15), "utf-8", 1),
    "units_below": ("time,furnace\nmin,°F\n" + rows(TIME / 60, 1.8 * HOT + 32), "utf-8", 1),
    "lines_above": ("Test 12\nLab, hall 3\n\nTime (s),Temperature (°C)\n" + rows(TIME, HOT), "utf-8", 1),
    "decimal_commas": (
        ("Zeit [min];Ofen 1 [°C];Raum\n" + rows(TIME / 60, HOT, 0 * HOT + 20.1, mark=";")).replace(".", ","),
        "utf-8",
        1,
    ),
    "one_thermocouple_fails": (
        "time,furnace_1,furnace_2\n" + rows(TIME, HOT, np.where(TIME > 1800.0, np.nan, HOT)),
        "utf-8",
        2,
    ),
}


@pytest.mark.parametrize("name", READ)
def test_read(tmp_path, name):
    """Every one of them is the standard's curve, within what a column of them is off."""
    text, encoding, count = READ[name]
    path = tmp_path / f"{name}.csv"
    path.write_bytes(text.encode(encoding))
    furnace = read_log(path, 60.0, "iso_834")
    assert furnace(3600.0) == pytest.approx(945.34, abs=0.01)
    assert furnace(15.0) == pytest.approx(0.5 * (HOT[0] + HOT[1]), abs=0.01)
    assert len(furnace.names) == count
    converted = {"latin_1", "minutes", "hours", "fahrenheit", "kelvin", "units_below", "decimal_commas"}
    assert not converted & {name} or furnace.notes, "what was converted is said"


def test_rows_of_a_minute_kept_in_hours_are_no_gap(tmp_path):
    """61/60 h times 3600 is not 3660 to the last bit."""
    path = tmp_path / "log.csv"
    hours = np.arange(61) / 60.0
    path.write_text("time,temperature\n" + rows(hours * 3600.0, iso_834(hours * 3600.0)))
    assert read_log(path, 60.0)(3600.0) == pytest.approx(945.34, abs=0.01)


REFUSED = {
    "late": ("time,temperature\n" + rows(TIME[20:], HOT[20:]), "begins at 600 s"),
    "fahrenheit": ("time,furnace\n" + rows(TIME, 1.8 * HOT + 32), "if read as °F"),
    "minutes": ("time,furnace\n" + rows(TIME / 60, HOT), "if read as minutes"),
    "milliseconds": ("time,furnace\n" + rows(1e3 * TIME, HOT), "if read as milliseconds"),
    "only_ambient": ("time,ambient,pressure\n" + rows(TIME, HOT, HOT), "give one that begins with"),
    "no_time": ("a,b\n1,2\n2,3\n", "give one called time"),
    "no_rows": ("time,furnace\n0,20\n", "give two or more"),
    "nothing": ("", "is empty"),
    "nothing_measured": ("time,furnace\n0,\n30,\n60,\n", "no finite temperature"),
    "back": ("time,furnace\n0,20\n60,300\n30,200\n", r":4: time is 30; give times that increase"),
    "half_clock": ("time,furnace\n0:00,20\n0:30,300\n", "hours:minutes:seconds"),
    "twice": ("time,furnace,furnace\n0,20,20\n30,300,300\n", "two columns furnace"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(tmp_path, name):
    text, said = REFUSED[name]
    path = tmp_path / f"{name}.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError, match=said) as refusal:
        read_log(path, 60.0, "iso_834")
    assert str(path) in str(refusal.value)


def test_a_furnace_that_follows_no_curve_is_taken_as_it_is(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,furnace\n" + rows(TIME, 0 * HOT + 20.0))
    assert read_log(path, 60.0, "iso_834")(3600.0) == 20.0


def test_thermocouples_with_units_and_several_furnace_columns(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(
        "time_min,furnace_1,furnace_2,tc_1 [°F],ftp_centre\n0,10,30,68,20\n1,340,360,212,21\n2,,444,,22\n",
        encoding="utf-8",
    )
    log = read_thermocouple_log(path)
    np.testing.assert_allclose(log.time, [0.0, 60.0, 120.0])
    np.testing.assert_allclose(log.furnace, [20.0, 350.0, 444.0])
    np.testing.assert_allclose(log.readings["tc_1"], [20.0, 100.0, np.nan])
    assert set(log.readings) == {"tc_1", "ftp_centre"}
    assert any("°F" in note for note in log.notes)
