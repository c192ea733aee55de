"""`flexsim info` finds what was put wrong into a bag, where it was put, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import BagWriter
from made_bags import Topics, diagnostics, joint_state, stamp
from processes import flexsim
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

pytestmark = pytest.mark.ros

RATE, DURATION = 1000, 6.0
ENERGIES = ("kinetic energy, J", "elastic energy, J", "gravitational energy, J")


def write(path: Path, *, wrong: bool) -> Path:
    """Write a pendulum under a constant torque: E = torque * q; with `wrong`, six things go wrong."""
    torque = 2.0
    with BagWriter(path) as bag:
        topics = Topics(bag)
        sequence = 0
        for k in range(round(DURATION * RATE)):
            t = k / RATE
            q = 1.0 - np.cos(3.0 * t)
            sequence += 1
            if wrong and 2.0 < t < 2.05:
                continue  # never came: silence, and numbers that are missing
            topics.write("/joint_states", joint_state(t, ["a"], [q], [0.0], [torque]), t, sequence)
            if k % 10 == 0:
                # The clock is set back by half a second, and goes on from there.
                back = 0.5 if wrong and t >= 3.0 else 0.0
                clock = serialize_message(Clock(clock=stamp(t - back)))
                topics.write("/clock", clock, t, 1 + k // 10)
            if k % RATE == 500:
                second = k // RATE
                work = torque * q
                gained = 0.3 * (second >= 4) if wrong else 0.0
                late = wrong and second == 1
                validity = 0.2 if wrong and second in (3, 4) else 0.01
                said = {
                    "real time": (int(late), "3 overruns in the last second" if late else "realtime",
                                  {"overruns": 3 if wrong and second >= 1 else 0, "ticks": k}),
                    "solver": (0, "ok", dict(zip(ENERGIES, (work + gained, 0.0, 7.0), strict=True))),
                    "validity": (int(validity > 0.1), "link_1: the elastic rotation reaches 0.2 rad"
                                 if validity > 0.1 else "within its limits",
                                 {"elastic_rotation": validity, "elastic_rotation, limits": "0.1, 0.5"}),
                }  # fmt: skip
                topics.write("/diagnostics", diagnostics(t, said), t)
    return path


def test_what_went_wrong(tmp_path: Path) -> None:
    """Each finding says what and when."""
    bag = write(tmp_path / "run", wrong=True)
    done = flexsim("info", bag, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    joints = found["topics"]["/joint_states"]
    assert joints["interval"] == pytest.approx(1e-3, rel=1e-6)
    assert joints["gaps"] == [[pytest.approx(2.0), pytest.approx(2.05), 0]]
    assert joints["lost"] == 49
    assert joints["losses"] == [[pytest.approx(2.0), pytest.approx(2.05), 49]]
    assert joints["missing_stamps"] == 49
    assert found["topics"]["/clock"]["clock_jumps"] == [
        [pytest.approx(3.0), pytest.approx(2.99), pytest.approx(2.5)]
    ]
    assert joints["clock_jumps"] == []
    assert found["overruns"] == 3
    assert found["overruns_at"] == [[pytest.approx(1.5), 3]]
    late, valid = found["warnings"]
    assert late["name"] == "flexsim_node: real time"
    assert [late["begin"], late["end"]] == [pytest.approx(1.5), pytest.approx(1.5)]
    assert "reaches 0.2 rad" in valid["message"]
    assert [valid["begin"], valid["end"]] == [pytest.approx(3.5), pytest.approx(4.5)]
    assert found["validity"]["elastic_rotation"] == {
        "largest": 0.2, "at": pytest.approx(3.5), "warn": 0.1, "stop": 0.5,
    }  # fmt: skip
    (gain,) = found["energy_gains"]
    assert gain["at"] == pytest.approx(4.5)
    assert gain["gained"] - gain["work"] == pytest.approx(0.3)

    shown = flexsim("info", bag).stdout
    for words in ("2.000 to 2.050", "49 messages", "time jumps back", "3 deadlines missed", "3.500 to 4.500"):
        assert words in shown


def test_two_nodes_on_one_topic(tmp_path: Path) -> None:
    """Each counts and stamps by itself: nothing is lost, no clock jumps; a fall gains nothing."""
    with BagWriter(tmp_path / "run") as bag:
        topics = Topics(bag)
        for k in range(2000):
            topics.write("/joint_states", joint_state(k / RATE, ["a"], [0.0], [0.0], [0.0]), k / RATE, k + 1)
        for k in range(20):
            t = 0.1 * k + 0.05
            energies = dict(zip(ENERGIES, (5.0 + k, 0.0, -k + 1e-4 * k), strict=True))
            topics.write("/diagnostics", diagnostics(t, {"solver": (0, "ok", energies)}), t, 7 + k)
            door = diagnostics(60.0 * t, {"pace": (0, "running", {})})
            topics.write("/diagnostics", door, t + 0.03, 1 + k)
    found = json.loads(flexsim("info", tmp_path / "run", "--json").stdout)
    both = found["topics"]["/diagnostics"]
    assert both["clock_jumps"] == [] and both["lost"] is None
    assert found["energy_checked"] == 19 and found["energy_gains"] == []


def test_a_run_that_went_well(tmp_path: Path) -> None:
    """Nothing is found where nothing is wrong; without reading, the index alone is shown."""
    bag = write(tmp_path / "run", wrong=False)
    done = flexsim("info", bag)
    assert "Nothing that was recorded went wrong" in done.stdout
    found = json.loads(flexsim("info", bag, "--json").stdout)
    assert found["energy_checked"] == 5
    assert found["energy_gains"] == found["warnings"] == found["overruns_at"] == []
    quick = json.loads(flexsim("info", bag, "--quick", "--json").stdout)
    assert "overruns" not in quick
    assert quick["topics"]["/joint_states"]["messages"] == round(DURATION * RATE)
