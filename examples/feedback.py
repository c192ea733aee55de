"""A controller that sees the joints: step by step, with a push on the tip."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene, static_equilibrium
from flexsim_node.motion.simulation import Simulation

CONFIG = Path(__file__).parents[1] / "config"
STIFFNESS, DAMPING = np.array([300.0, 300.0, 100.0]), np.array([25.0, 25.0, 8.0])

scene = load_scene(CONFIG / "anthropomorphic_geared.yaml")
robot = Simulation(scene)
goal = robot.joint_position().copy()
weight = static_equilibrium(scene, goal).torque  # what holds it still there

print("   t/s   push/N   off joint 2/mrad   torque 2/Nm")
for k in range(601):
    if k == 100:
        robot.apply("link_3", np.array([0.0, 0.0, 20.0, 0.0, 0.0, 0.0]), base=True)
    if k == 200:
        robot.apply(None)  # all loads off
    error = goal - robot.joint_position()
    torque = weight + STIFFNESS * error - DAMPING * robot.joint_velocity()
    if k % 100 == 0:
        pushed = 20.0 if 100 <= k < 200 else 0.0
        print(f"{robot.time:6.2f} {pushed:8.1f} {-1e3 * error[1]:18.3f} {torque[1]:13.3f}")
    robot.command(torque)
    if robot.step() or not robot.check():
        raise SystemExit(robot.reason)
