"""Robots of reduced links move as the full ones do, nearly."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_reduction import arm, planar, reduced_to

from flexsim_node import load_scene, simulate


def kicks(t):
    """Torques that jump, with tones."""
    kick = 8.0 if t < 0.05 else (-8.0 if t < 0.1 else 0.0)
    return np.array([kick + 2.0 * np.sin(150.0 * t), 12.0 + kick + np.sin(250.0 * t), 4.0 - 0.5 * kick])


def tones(t):
    """A slow swing, and tones near the lowest modes."""
    return np.array(
        [5 * np.sin(2 * np.pi * t) + 2 * np.sin(120 * t), 14 + 2 * np.sin(180 * t), 3.5 + np.sin(300 * t)]
    )


@pytest.mark.parametrize(("torques", "friction"), [(kicks, 2.0), (tones, 0.0)])
def test_tip_moves_as_the_full_model_s(torques, friction):
    """Six modes a link: the tip within 1 % of its vibration, on three links of eight elements.

    Kicked without friction the arm tumbles: then runs of the full model with different steps part as well.
    """
    scene = arm(8, 2e-6)
    for n in range(3):
        scene = load_scene(scene.model_dump(), {f"links.{n}.joint.viscous_friction": friction})
    torque = np.array([torques(k * 1e-3) for k in range(500)])
    full = simulate(scene, torque, 0.5)
    part = simulate(reduced_to(6, scene), torque, 0.5)
    assert full.status == part.status == "ok"
    vibration = np.max(np.linalg.norm(full.node_position[:, -1] - full.rigid_position[:, -1], axis=1))
    apart = np.max(np.linalg.norm(full.link_end[:, -1] - part.link_end[:, -1], axis=1))
    print(f"vibration {1e3 * vibration:.3f} mm, difference {1e3 * apart:.5f} mm")
    assert vibration > 5e-3
    assert apart < 0.01 * vibration
    # every node is shown, and moves likewise
    assert part.node_names == full.node_names
    assert np.max(np.abs(part.node_position - full.node_position)) < 0.01 * vibration


def test_energy_is_kept():
    """A reduced robot in free motion at several rad/s neither gains nor loses energy."""
    scene = load_scene(
        planar(beam={"elements": 6, "youngs_modulus": 2e10}, damping={}),
        {
            "reduction.modes": 4,
            "solver": {"method": "radau", "relative_tolerance": 1e-9, "absolute_tolerance": 1e-11},
            "initial": {"position": [0.3, 0.5], "velocity": [4.0, 6.0]},
        },
    )
    run = simulate(scene, None, 0.06, 0.01)
    assert run.status == "ok"
    assert np.max(np.abs(run.node_displacement)) > 1e-4
    swing = np.ptp(run.node_position[:, -1, 1]) * 9.0
    assert np.ptp(run.energy) < 1e-6 * swing


def test_benchmark_smoke():
    """The benchmark of reduced links runs and says what it promises; its figures are not judged here."""
    script = Path(__file__).parents[2] / "benchmarks" / "reduction.py"
    done = subprocess.run(
        [sys.executable, script, "--quick", "--json"], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    for kind, unknowns in (("spatial", [147, 39]), ("planar", [75, 30])):
        for run in found[kind].values():
            assert run["unknowns"] == unknowns
            assert run["ratio_of_best"] > 0.0 and run["difference_mm"] < 0.01
