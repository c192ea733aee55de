"""A measured furnace: a slip of a thermocouple is refused and named, and does not end a fire test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from door_scenes import door

from thermal_node import load_scene
from thermal_node.furnace.plausibility import NOT_FINITE, TOO_FAST, TOO_HIGH, TOO_LOW, Limits, Plausibility
from thermal_node.service.fire_test import FireTest
from thermal_node.service.settings import SettingError, settings


def iso_834(time: float) -> float:
    """Standard curve, °C."""
    return 20.0 + 345.0 * math.log10(8.0 * time / 60.0 + 1.0)


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (math.nan, NOT_FINITE),
        (-math.inf, NOT_FINITE),
        (-60.0, TOO_LOW),
        (1372.0, TOO_HIGH),  # an open thermocouple of type K
        (3000.0, TOO_HIGH),
        (1200.0, TOO_FAST),
        (20.0, TOO_FAST),
    ],
)
def test_a_slip_is_refused_and_the_next_value_believed(value: float, reason: str) -> None:
    """Ten minutes into a test one value is wrong: it alone is refused, with the reason that holds."""
    judge = Plausibility(Limits())
    assert all(judge.check(float(t), iso_834(t)) is None for t in range(600))
    refused = judge.check(600.0, value)
    assert refused is not None and refused.reason == reason
    assert judge.check(601.0, iso_834(601.0)) is None


def test_every_standard_fire_is_believed() -> None:
    """From the first second on, at a value a second and with the noise of a furnace."""
    noise = np.random.default_rng(1).normal(0.0, 8.0, 7200)
    hydrocarbon = [20.0 + 1080.0 * (1.0 - 0.325 * math.exp(-t / 359.28) - 0.675 * math.exp(-t / 24.0))
                   for t in range(7200)]  # fmt: skip
    for curve in ([iso_834(t) for t in range(7200)], hydrocarbon):
        judge = Plausibility(Limits())
        assert [judge.check(float(t), v + n) for t, (v, n) in enumerate(zip(curve, noise, strict=True))] == (
            [None] * 7200
        )


def test_what_stays_off_is_no_slip() -> None:
    """A first value that was wrong is put right by those that follow, which agree with each other."""
    judge = Plausibility(Limits(confirmations=5))
    assert judge.check(0.0, 1300.0) is None
    judged = [judge.check(float(t), 20.0 + t) for t in range(1, 8)]
    assert [one is None for one in judged] == [False] * 4 + [True] * 3
    # Slips that do not agree are never believed.
    noisy = [judge.check(7.0 + 0.05 * t, value) for t, value in enumerate((900.0, 300.0) * 10)]
    assert all(one is not None for one in noisy)


def test_the_march_goes_on_after_a_stop() -> None:
    """What stopped it came from the furnace: it goes on from the last tick that was good."""
    table = {"temperature": [10, 100, 300], "value": [0.035, 0.043, 0.073]}
    wool = {"density": 120.0, "specific_heat": 1000.0, "conductivity": {**table, "beyond": "refuse"}}
    scene = load_scene(door(materials={"rock_wool": wool}, solver={"model": "column", "step": "auto"}))
    test = FireTest(scene)
    test.measure(200.0)
    assert all(test.advance(float(t)).ok for t in range(1, 121))
    assert not test.go_on()  # it has not stopped
    test.measure(1300.0)
    tick = 121
    while test.advance(float(tick)).ok:
        tick += 1
        assert tick < 1000
    assert "beyond the end of its conductivity table" in test.status.reason
    assert not test.advance(tick + 1.0).ok
    test.measure(200.0)
    steps = test.heat.steps
    assert test.go_on()
    assert test.time == tick - 1.0 and test.heat.steps == steps  # nothing of what it did is forgotten
    hottest = test.temperature.max()
    assert all(test.advance(float(t)).ok for t in range(tick, tick + 60))
    assert 200.0 < test.temperature.max() < hottest
    test.reset()
    assert not test.go_on()


def test_what_stopped_the_march_leaves_no_trace() -> None:
    """After a tick that was undone the door is, to the bit, one whose furnace never measured that value."""
    table = {"temperature": [10, 100, 300], "value": [0.035, 0.043, 0.073]}
    wool = {"density": 120.0, "specific_heat": 1000.0, "conductivity": {**table, "beyond": "refuse"}}
    scene = load_scene(
        door(materials={"rock_wool": wool}, solver={"model": "column"}, exposed={"film_coefficient": 1e4})
    )

    def burnt(slips: bool) -> FireTest:
        test = FireTest(scene)
        test.measure(200.0)
        assert test.advance(60.0).ok
        if slips:
            test.measure(1300.0)
            assert not test.advance(61.0).ok
            assert test.go_on()
        for tick in (61.0, 62.0):
            test.measure(210.0)
            assert test.advance(tick).ok
        return test

    slipped, never = burnt(True), burnt(False)
    np.testing.assert_array_equal(slipped.heat.temperature, never.heat.temperature)
    assert slipped.heat.balance == never.heat.balance
    assert [c.value for c in slipped.criteria.each] == [c.value for c in never.criteria.each]


def test_limits_that_cant_be_are_refused() -> None:
    """Each says what would be right."""
    for name, value, right in (
        ("furnace_rate", -1.0, "give K/s"),
        ("furnace_jump", math.nan, "give K"),
        ("furnace_highest", 4000.0, "-273 to 3000"),
        ("furnace_lowest", 1400.0, "the lowest first"),
        ("furnace_confirmations", 0, "give 1 or more"),
    ):
        with pytest.raises(SettingError, match=right):
            settings({"scene": "a.yaml", name: value})
