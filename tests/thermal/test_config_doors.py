"""The doors of config/ that have a cavity, water or a binder: they burn, and this is what they come to.

The numbers are what the programs of test_gaps.py and test_reactions.py vouch for; here it is looked at that
each part of these scenes decides something.
"""

from pathlib import Path

from thermal_node import load_scene, simulate

CONFIG = Path(__file__).resolve().parents[2] / "config"


def burn(name, **overrides):
    changes = {key.replace("__", "."): value for key, value in overrides.items()}
    run = simulate(load_scene(CONFIG / name, changes), 3600.0, 60.0)
    assert run.status.ok, run.status
    assert run.balance.worst < 1e-6
    return run


def test_a_bulkhead_whose_binder_burns_holds_its_hour():
    run = burn("bulkhead_a60.yaml")
    assert run.verdict.startswith("A-60 by insulation alone")
    assert run.balance.released > 1e6
    without = burn("bulkhead_a60.yaml", materials__wool__reactions=[])
    assert without.balance.released == 0.0
    assert run.probes["ftp_centre"][-1] != without.probes["ftp_centre"][-1]


def test_two_skins_hold_an_hour_by_their_cavity():
    run = burn("double_skin_door.yaml")
    assert "I1 60, I2 60" in run.verdict
    shining = burn("double_skin_door.yaml", leaf__layers__2__emissivity=[0.05, 0.05])
    assert shining.probes["ftp_centre"][-1] < run.probes["ftp_centre"][-1] - 5.0


def test_a_gypsum_leaf_holds_by_its_water():
    run = burn("gypsum_door.yaml")
    without = burn("gypsum_door.yaml", materials__gypsum__reactions=[])
    assert run.verdict.startswith("I2 60")
    assert without.verdict.startswith("I2 45")
    assert run.balance.released < -5e6
