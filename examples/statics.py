"""Statics: holding torques and sag of an arm with a payload, without a simulation."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene, static_equilibrium

CONFIG = Path(__file__).parents[1] / "config"

print("payload/kg   holding torques/Nm             tip sags by/mm")
for mass in (0.0, 0.5, 1.0, 2.0):
    scene = load_scene(CONFIG / "anthropomorphic.yaml", {"links.link_3.payload.mass": mass})
    rest = static_equilibrium(scene, [0.0, 0.3, -0.3])
    bare = load_scene(CONFIG / "anthropomorphic.yaml", {"gravity": [0, 0, 0]})
    straight = static_equilibrium(bare, [0.0, 0.3, -0.3])
    sag = 1e3 * (straight.link_end[-1, 2] - rest.link_end[-1, 2])
    torques = "".join(f"{torque:9.3f}" for torque in np.round(rest.torque, 3) + 0.0)
    print(f"{mass:10.1f} {torques} {sag:22.3f}")
