"""Faults on purpose: a controller that is good on paper, with delays and a slow actuator."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation

CONFIG = Path(__file__).parents[1] / "config"
STIFFNESS, DAMPING = np.array([900.0, 900.0, 300.0]), np.array([40.0, 40.0, 12.0])
FAULTS = {
    "none": [],
    "commands 3 ms late": [{"kind": "delay", "time": 0.003}],
    "commands 10 ms late": [{"kind": "delay", "time": 0.010}],
    "actuators of 5 ms": [{"kind": "lag", "time_constant": 0.005}],
    "one command in three lost": [{"kind": "drop", "probability": 0.33}],
    "encoder of 1 mrad": [{"kind": "quantize", "signal": "position", "resolution": 1e-3}],
}


def settle(faults: list) -> str:
    """What is left of a step of 20 mrad in joint 2 after 0.4 s, as the encoders show it."""
    scene = load_scene(CONFIG / "anthropomorphic_geared.yaml", {"gravity": [0, 0, 0], "faults": faults})
    robot = Simulation(scene)
    goal = np.array([0.0, 0.62, -0.8])
    errors, torques = [], []
    for _ in range(500):
        error = goal - robot.joint_position()
        torque = STIFFNESS * error - DAMPING * robot.joint_velocity()
        robot.command(torque)
        if robot.step():
            return f"  stopped at {robot.time:.2f} s: {robot.reason}"
        errors.append(np.abs(error).max())
        torques.append(torque[1])
    return f"{1e3 * max(errors[-100:]):>12.3f}{np.ptp(torques[-100:]):>22.3f}"


print(f"{'fault':<28}{'error/mrad':>12}{'torque swings by/Nm':>22}")
for name, faults in FAULTS.items():
    print(f"{name:<28}{settle(faults)}")
