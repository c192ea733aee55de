"""Controllers without ROS: three example laws drive the full robot through one move."""

from pathlib import Path

import numpy as np
from flexsim.controller.laws import JointPd, Lqg, ShapedPd
from flexsim.controller.trajectory import Trajectory

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation

CONFIG = Path(__file__).parents[1] / "config"

scene = load_scene(CONFIG / "anthropomorphic_geared.yaml")
start, goal = np.array([0.0, 0.6, -0.8]), np.array([0.4, 0.9, -1.1])
# rest, a move of 0.3 s, rest
way = Trajectory(np.array([0.0, 0.3]), np.array([start, goal]), np.zeros((2, 3)))

print(f"{'law':<12}{'off the plan by/mrad':>22}{'tip swings 0.2 s after the move/mm':>38}")
for law_of in (JointPd, ShapedPd, Lqg):
    robot, law = Simulation(scene), law_of(scene, way, scene.solver.step)
    errors, swing = [], []
    for k in range(700):
        position, velocity = robot.joint_position(), robot.joint_velocity()
        deflection = robot.look().displacement[-1]
        torque = law.torque(robot.time, position, velocity, deflection)
        errors.append(np.abs(position - way.at(robot.time)[0]).max())
        if k > 500:
            swing.append(robot.look().link_end[-1].copy())
        robot.command(torque)
        if robot.step():
            raise SystemExit(robot.reason)
    print(f"{law_of.__name__:<12}{1e3 * max(errors):>22.2f}{1e3 * np.ptp(swing, axis=0).max():>38.3f}")
