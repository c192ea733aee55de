"""From a scene to a linear model to a linear-quadratic regulator, tried on the full robot."""

from pathlib import Path

import numpy as np
from scipy.linalg import solve_continuous_are

from flexsim_node import linearize, load_scene
from flexsim_node.motion.simulation import Simulation

CONFIG = Path(__file__).parents[1] / "config"

scene = load_scene(CONFIG / "anthropomorphic_geared.yaml", {"initial.shape": "undeformed"})
pose = [0.0, 0.6, -0.8]
model = linearize(scene, pose)
m = len(model.input_names)

# the joints alone move the regulator: the elastic unknowns follow as if they had no mass of their own
rigid = np.zeros((len(model.mass), m))
rigid[:m] = np.eye(m)
rigid[m:] = -np.linalg.solve(model.stiffness[m:, m:], model.stiffness[m:, :m])
mass, stiffness = (rigid.T @ matrix @ rigid for matrix in (model.mass, model.stiffness))
A = np.block([[np.zeros((m, m)), np.eye(m)], [-np.linalg.solve(mass, stiffness), np.zeros((m, m))]])
B = np.vstack([np.zeros((m, m)), np.linalg.inv(mass)])
cost = np.diag([400.0] * m + [1.0] * m)
gain = np.linalg.solve(np.eye(m) * 0.1, B.T @ solve_continuous_are(A, B, cost, 0.1 * np.eye(m)))

closed = model.A.copy()
n = len(model.mass)
closed[:, :m] -= model.B @ gain[:, :m]
closed[:, n : n + m] -= model.B @ gain[:, m:]
slowest = np.linalg.eigvals(closed).real.max()
print(f"{n} unknowns, gains from {2 * m} states; slowest pole with all of them: {slowest:.2f} 1/s")

robot = Simulation(scene)
robot.x[:m] += [0.05, -0.05, 0.05]  # let go beside the pose, unbent
robot.prepare()
print("   t/s   largest error of a joint/mrad")
for k in range(501):
    off = np.concatenate([robot.joint_position() - pose, robot.joint_velocity()])
    if k % 100 == 0:
        print(f"{robot.time:6.2f} {1e3 * np.abs(off[:m]).max():20.3f}")
    robot.command(model.torque - gain @ off)
    if robot.step():
        raise SystemExit(robot.reason)
