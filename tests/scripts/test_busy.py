"""A trial that failed, or is to be believed, on a machine that had no time says so, with the figures."""

from __future__ import annotations

from pathlib import Path

import pytest
from flexsim.bag import BagWriter
from flexsim.trial.busy import pace_of, too_busy
from flexsim.trial.processes import taken
from made_bags import at, diagnostics

KEPT = {
    "ticks": 1000,
    "overruns": 3,
    "overruns in a row, worst": 2,
    "lateness p99, µs": 80.0,
    "lateness worst, µs": 1500.0,
    "lost time, s": 0.0,
}


@pytest.mark.parametrize(
    ("change", "busy"),
    [
        ({}, False),
        ({"overruns": 30}, True),
        ({"lateness p99, µs": 9000.0}, True),
        ({"lost time, s": 0.2}, True),
    ],
)
def test_busy_or_not(change: dict[str, float], busy: bool, tmp_path: Path) -> None:
    """Deadlines missed, late or given up: each makes it busy; the sentence names them all and the load."""
    with BagWriter(tmp_path / "run") as bag:
        topic = bag.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        bag.write(topic, diagnostics(1.0, {"real time": (0, "", KEPT | change)}), at(1.0))
    said = too_busy(tmp_path / "run")
    assert bool(said) == busy
    if busy:
        assert f"{(KEPT | change)['overruns']} of 1000 deadlines missed" in said
        assert "load" in said and "processors" in said


def test_a_bag_that_does_not_say(tmp_path: Path) -> None:
    """Nothing is claimed of a machine of which nothing is known."""
    assert pace_of(tmp_path / "nowhere") is None and too_busy(tmp_path / "nowhere") == ""


def test_a_domain_is_one_trial_s() -> None:
    """Two demos that begin at once do not meet, though neither has opened a port yet."""
    assert taken(1051)
    assert not taken(1051)
