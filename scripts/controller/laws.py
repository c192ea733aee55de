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


class Rest:
    """The robot at rest along a trajectory, tabulated.

    Attributes
    ----------
    torque : (PLACES, m) that carries the weight
    deflection : (PLACES, 6) of the last link's end, m and rad in its frame
    """

    def __init__(self, scene: Scene, trajectory: Trajectory) -> None:
        self.time = np.linspace(trajectory.time[0], trajectory.time[-1], PLACES)
        found = [static_equilibrium(scene, trajectory.at(t)[0]) for t in self.time]
        self.torque = np.array([rest.torque for rest in found])
        self.deflection = np.array([rest.node_displacement[-1] for rest in found])

    def at(self, t: float) -> tuple[Vector, Vector]:
        """Torque (m,) and deflection (6,) at a time."""
        place = (t - self.time[0]) / (self.time[-1] - self.time[0]) * (PLACES - 1)
        place = min(max(place, 0.0), PLACES - 1.0)
        k = min(int(place), PLACES - 2)
        s = place - k
        torque, deflection = self.torque, self.deflection
        return (
            (1.0 - s) * torque[k] + s * torque[k + 1],
            (1.0 - s) * deflection[k] + s * deflection[k + 1],
        )


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
        self.rest = Rest(scene, trajectory)

    def wanted(self, t: float) -> tuple[Vector, Vector]:
        """Position and velocity to follow."""
        return self.trajectory.at(t)

    def torque(self, t: float, position: Vector, velocity: Vector, deflection: Vector) -> Vector:
        """Torque for a state."""
        q, rate = self.wanted(t)
        return np.asarray(
            self.rest.at(t)[0] + self.stiffness * (q - position) + self.damping * (rate - velocity)
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
    """Linear-quadratic regulator on a Kalman filter.

    It measures the joints and the deflection of the last link's end, so that it knows how the links swing,
    and damps what a joint servo does not see.  Its state is the deviation from the robot that rests where it
    is wanted, so that none is left at the end of the way; the model is that of the middle of the way.
    """

    deflection = True

    def __init__(self, scene: Scene, trajectory: Trajectory, period: float) -> None:
        self.trajectory = trajectory
        self.rest = Rest(scene, trajectory)
        middle = trajectory.position[len(trajectory.time) // 2]
        last = scene.links[-1]
        count = last.beam.elements if last.beam is not None and last.flexible else int(last.length > 0.0)
        end = f"node_displacement:{last.name}/{count}"
        full = linearize(scene, middle, ("joint_position", "joint_velocity", end))
        m = len(scene.joint_names)
        model = full.reduced(min(len(full.mass), m + ELASTIC_MODES))
        states = model.A.shape[0]
        scale = np.concatenate([np.ones(states // 2), np.full(states // 2, 2.0 * np.pi * 10.0)])
        advance, push = model.discretize(period)
        seen = slice(0, 2 * m + 6)
        self.output, self.direct = model.C[seen], model.D[seen]
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
        # When it was asked the last time, and what was wanted then.
        self.before: tuple[float, Vector, Vector] = (0.0, np.zeros(m), np.zeros(m))

    def torque(self, t: float, position: Vector, velocity: Vector, deflection: Vector) -> Vector:
        """Torque for a state."""
        q, rate = self.trajectory.at(t)
        weight, sag = self.rest.at(t)
        measured = np.concatenate([position - q, velocity - rate, deflection - sag])
        if self.state is None:
            self.state = self.rigid @ measured[: 2 * len(q)]
        else:
            # The robot goes on as it did; what is wanted goes its own way.
            since, last, last_rate = self.before
            apart = np.concatenate([last + (t - since) * last_rate - q, last_rate - rate])
            self.state = self.advance @ self.state + self.push @ self.given + self.rigid @ apart
        self.before = (t, q, rate)
        expected = self.output @ self.state + self.direct @ self.given
        self.state = self.state + self.correct @ (measured - expected)
        self.given = -self.gain @ self.state
        return np.asarray(weight + self.given)


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
