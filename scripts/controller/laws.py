"""Example control laws: each answers a measured state with torques, and knows nothing of ROS."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, eigh, solve_discrete_are

from flexsim_node import Scene, linearize, natural_frequencies, static_equilibrium

from .shaping import for_modes
from .trajectory import Trajectory

Vector = NDArray[np.float64]
PLACES = 41  # where gravity's torques are tabulated along the way
BANDWIDTH = 1.0  # of a joint's servo, as part of the first frequency with locked joints
MODES_TO_SHAPE = 2
ELASTIC_MODES = 4  # that the LQG controller knows
# What costs it one: a joint's error of 1/20 rad, its rate of 1 rad/s, and the torque of a servo as stiff as
# JointPd's that is off by 1/20 rad.
ERROR_WEIGHT, RATE_WEIGHT, EFFORT = 400.0, 1.0, 20.0


class Law(Protocol):
    """A controller that follows a trajectory.

    Attributes
    ----------
    deflection : whether it wants the deflection of the last link's end beside the joints' states
    """

    deflection: bool

    def torque(self, t: float, position: Vector, velocity: Vector, deflection: Vector) -> Vector:
        """Return the torque (m,) for the state measured at t.

        position, velocity (m,) of the joints; deflection (6,) of the last link's end from the rigid link, in
        its frame, m and rad.
        """


class Weight:
    """The torques that carry the robot's weight along a trajectory, tabulated."""

    def __init__(self, scene: Scene, trajectory: Trajectory) -> None:
        way = np.linspace(trajectory.time[0], trajectory.time[-1], PLACES)
        self.time = way
        self.torque = np.array([static_equilibrium(scene, trajectory.at(t)[0]).torque for t in way])

    def at(self, t: float) -> Vector:
        """Torque (m,) at a time."""
        return np.array([np.interp(t, self.time, column) for column in self.torque.T])


def servo(scene: Scene, position: Vector) -> tuple[Vector, Vector]:
    """Stiffness and damping (m,) of joint servos: critically damped, as fast as the first frequency.

    Each joint moves the inertia that it sees with the others at rest.
    """
    model = linearize(scene, position)
    n = len(scene.joint_names)
    inertia = np.array([rigid_inertia(model.mass, model.stiffness, model.force, k, n) for k in range(n)])
    bandwidth = BANDWIDTH * 2.0 * np.pi * natural_frequencies(scene, position, locked=True)[0]
    return inertia * bandwidth**2, 2.0 * inertia * bandwidth


def rigid_inertia(mass: Vector, stiffness: Vector, force: Vector, k: int, joints: int) -> float:
    """Inertia about joint k when nothing bends: the mass matrix along the rigid motion of a unit turn."""
    n = len(mass)
    elastic = np.arange(joints, n)
    # the elastic unknowns that go with a turn of the motor without strain
    rigid = np.zeros(n)
    rigid[k] = 1.0
    block = stiffness[np.ix_(elastic, elastic)]
    rigid[elastic] = -np.linalg.solve(block, stiffness[elastic, k])
    return float(rigid @ mass @ rigid)


class JointPd:
    """Joint PD with the weight fed forward."""

    deflection = False

    def __init__(self, scene: Scene, trajectory: Trajectory, period: float) -> None:
        self.trajectory = trajectory
        middle = trajectory.position[len(trajectory.time) // 2]
        self.stiffness, self.damping = servo(scene, middle)
        self.weight = Weight(scene, trajectory)

    def wanted(self, t: float) -> tuple[Vector, Vector]:
        """Position and velocity to follow."""
        return self.trajectory.at(t)

    def torque(self, t: float, position: Vector, velocity: Vector, deflection: Vector) -> Vector:
        """Torque for a state."""
        q, rate = self.wanted(t)
        return np.asarray(
            self.weight.at(t) + self.stiffness * (q - position) + self.damping * (rate - velocity)
        )


class ShapedPd(JointPd):
    """The same on a motion shaped (ZVD) against the robot's first modes under these servos."""

    def __init__(self, scene: Scene, trajectory: Trajectory, period: float) -> None:
        super().__init__(scene, trajectory, period)
        self.shaper = for_modes("zvd", self.modes(scene))

    def modes(self, scene: Scene) -> list[tuple[float, float]]:
        """Frequency, Hz, and damping ratio of the least damped slow modes, the servos closed."""
        middle = self.trajectory.position[len(self.trajectory.time) // 2]
        model = linearize(scene, middle)
        gain = np.hstack([np.diag(self.stiffness), np.diag(self.damping)])
        poles = np.linalg.eigvals(model.A - model.B @ gain @ model.C)
        swinging = poles[(poles.imag > 0.0) & (-poles.real < 0.5 * abs(poles))]
        slow = swinging[np.argsort(abs(swinging))][:MODES_TO_SHAPE]
        return [(float(abs(p)) / (2.0 * np.pi), float(-p.real / abs(p))) for p in slow]

    def wanted(self, t: float) -> tuple[Vector, Vector]:
        """The shaped motion."""
        return self.trajectory.shaped(self.shaper, t)


class Lqg:
    """Linear-quadratic regulator on a Kalman filter, about the middle of the way.

    It measures the joints and the deflection of the last link's end, so that it knows how the links swing,
    and damps what a joint servo does not see.
    """

    deflection = True

    def __init__(self, scene: Scene, trajectory: Trajectory, period: float) -> None:
        self.trajectory = trajectory
        self.weight = Weight(scene, trajectory)
        middle = trajectory.position[len(trajectory.time) // 2]
        last = scene.links[-1]
        count = last.beam.elements if last.beam is not None and last.flexible else 1
        end = f"node_displacement:{last.name}/{count}"
        full = linearize(scene, middle, ("joint_position", "joint_velocity", end))
        m = len(scene.joint_names)
        model = full.reduced(min(len(full.mass), m + ELASTIC_MODES))
        states = model.A.shape[0]
        scale = np.concatenate([np.ones(states // 2), np.full(states // 2, 2.0 * np.pi * 10.0)])
        advance, push = model.discretize(period)
        seen = slice(0, 2 * m + 6)
        self.output, self.direct = model.C[seen], model.D[seen]
        self.rest = model.output[2 * m : 2 * m + 6]
        self.middle, self.period = middle, period
        # Cost: the joints' errors and rates, against torque.
        stiffness, _ = servo(scene, middle)
        joints, rates = model.C[:m], model.C[m : 2 * m]
        cost = ERROR_WEIGHT * joints.T @ joints + RATE_WEIGHT * rates.T @ rates
        effort = np.diag((EFFORT / np.maximum(stiffness, 1e-9)) ** 2)
        self.gain = regulator(advance, push, cost / period, effort / period, scale)
        noise = np.diag(np.r_[np.full(m, 3e-4), np.full(m, 3e-2), np.full(3, 3e-4), np.full(3, 3e-3)] ** 2)
        drive = push @ np.diag((0.02 * np.maximum(stiffness, 1e-9)) ** 2) @ push.T
        drive += 1e-12 * np.diag(scale**2)
        self.correct = estimator(advance, self.output, drive, noise, scale)
        self.advance, self.push = advance, push
        # A motion of the joints without bending, in the model's states: its modes' part in it.
        shapes = eigh(full.stiffness, full.mass)[1][:, : states // 2]
        part = (shapes.T @ full.mass)[:, :m]
        self.rigid = block_diag(part, part)
        self.state: Vector | None = None
        self.given = np.zeros(m)

    def torque(self, t: float, position: Vector, velocity: Vector, deflection: Vector) -> Vector:
        """Torque for a state."""
        measured = np.concatenate([position - self.middle, velocity, deflection - self.rest])
        if self.state is None:
            self.state = self.rigid @ measured[: 2 * len(position)]
        else:
            self.state = self.advance @ self.state + self.push @ self.given
        expected = self.output @ self.state + self.direct @ self.given
        self.state = self.state + self.correct @ (measured - expected)
        q, rate = self.trajectory.at(t)
        wanted = self.rigid @ np.concatenate([q - self.middle, rate])
        self.given = self.gain @ (wanted - self.state)
        return np.asarray(self.weight.at(t) + self.given)


def regulator(a: Vector, b: Vector, cost: Vector, effort: Vector, scale: Vector) -> Vector:
    """(i, n) gain K of u = -K x that costs least; scaled, so that the Riccati solver sees one size."""
    left, right = a * scale / scale[:, None], b / scale[:, None]
    weight = cost * np.outer(scale, scale)
    p = solve_discrete_are(left, right, weight + 1e-9 * np.eye(len(a)) * np.trace(weight) / len(a), effort)
    gain = np.linalg.solve(effort + right.T @ p @ right, right.T @ p @ left)
    return np.asarray(gain / scale)


def estimator(a: Vector, c: Vector, drive: Vector, noise: Vector, scale: Vector) -> Vector:
    """(n, p) gain of the stationary Kalman filter's correction."""
    left, shown = a * scale / scale[:, None], c * scale
    process = drive / np.outer(scale, scale)
    p = solve_discrete_are(left.T, shown.T, process, noise)
    return np.asarray(scale[:, None] * (p @ shown.T @ np.linalg.inv(shown @ p @ shown.T + noise)))


LAWS: dict[str, type[JointPd] | type[Lqg]] = {"joint_pd": JointPd, "shaped_pd": ShapedPd, "lqg": Lqg}
