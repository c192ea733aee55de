"""Load a scene, simulate it under a torque, look at the result."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene, simulate

CONFIG = Path(__file__).parents[1] / "config"

scene = load_scene(CONFIG / "anthropomorphic.yaml", {"solver.step": 1e-3})
run = simulate(scene, torque=lambda t: np.array([5.0 * np.sin(2.0 * np.pi * t), 0.0, 0.0]), duration=0.4)

print(f"{scene.name}: {run.status}, joints {', '.join(scene.joint_names)}")
print("   t/s   tip x/m  tip y/m  tip z/m   bent/mm   energy/J")
for k in range(0, len(run.time), 100):
    x, y, z = run.link_end[k, -1]
    bent = 1e3 * np.linalg.norm(run.node_position[k, -1] - run.rigid_position[k, -1])
    print(f"{run.time[k]:6.2f} {x:9.4f}{y:9.4f}{z:9.4f} {bent:9.4f} {run.energy[k]:10.4f}")
for warning in run.warnings:
    print("warning:", warning)
