"""The robot about a static equilibrium as a linear state space, for the design of controllers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve, eigh, expm

from ..equations.dynamics.tangent import damping_matrix, forces, mass_matrix, stiffness_matrix
from ..model.chain import COUNT, FIRST
from ..model.model import Model, build_model
from ..model.reduced.layout import MODES, ROWS
from ..motion.assembly import Assembly
from ..motion.rest_shape import check_position, rest_shape, unknowns_at
from ..motion.simulation import joint_index
from ..scene.schema import Scene
from .decide import decided
from .linear_outputs import linear_outputs

COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
CO_MOVING_COMPONENTS = ("u", "bz", "by", "tau", "cy", "cz")  # of an element, see co_moving/


@dataclass(frozen=True)
class LinearModel:
    """x' = A x + B (tau - torque), y - output = C x + D (tau - torque), with x the deviation of the state.

    The state holds n unknowns (joint coordinates of the rigid links, then elastic displacements in beam axes)
    and their rates; M q'' + damping q' + stiffness q = force (tau - torque).

    Attributes
    ----------
    A : (2n, 2n), B : (2n, i), C : (p, 2n), D : (p, i); SI units
    state_names : (2n,), input_names : (i,), output_names : (p,)
    position : (m,) joint coordinates of the equilibrium, rad or m
    torque : (i,) that holds it, N m or N
    state : (2n,) and output : (p,) of the equilibrium
    mass, damping, stiffness : (n, n); force : (n, i)
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    position: np.ndarray
    torque: np.ndarray
    state: np.ndarray
    output: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray

    def natural_frequencies(self) -> np.ndarray:
        """(n,) undamped natural frequencies, Hz, rising; zero for a joint that turns freely or falls over."""
        squared = eigh(self.stiffness, self.mass, eigvals_only=True)
        return np.sqrt(np.maximum(squared, 0.0)) / (2.0 * np.pi)

    def poles(self) -> np.ndarray:
        """(2n,) eigenvalues of A, rad/s, the slowest first."""
        scale = self._rate_scale()
        found = np.linalg.eigvals(self.A * (1.0 / scale)[:, None] * scale)
        return found[np.argsort(np.abs(found), kind="stable")]

    def discretize(self, period: float) -> tuple[np.ndarray, np.ndarray]:
        """(2n, 2n), (2n, i) of x[k+1] = Ad x[k] + Bd u[k] for torques held over `period` seconds."""
        if not (np.isfinite(period) and period > 0.0):
            raise ValueError(f"period {period!r}; give seconds, more than zero")
        states, inputs = self.B.shape
        scale = self._rate_scale()
        block = np.zeros((states + inputs, states + inputs))
        block[:states, :states] = self.A * (1.0 / scale)[:, None] * scale
        block[:states, states:] = self.B / scale[:, None]
        moved = expm(block * period)
        return moved[:states, :states] * scale[:, None] / scale, moved[:states, states:] * scale[:, None]

    def reduced(self, modes: int) -> LinearModel:
        """The model in its `modes` lowest undamped modes (free joints count as modes); 2 * modes states.

        The other modes follow their static deflection: what they add to an output stands in D.
        """
        n = len(self.mass)
        if not (isinstance(modes, (int, np.integer)) and 1 <= modes <= n):
            raise ValueError(f"modes {modes!r}; give a whole number from 1 to {n}")
        squared, shapes = eigh(self.stiffness, self.mass)
        kept, rest = shapes[:, :modes], shapes[:, modes:]
        by_position, by_rate = self.C[:, :n], self.C[:, n:]
        follows = by_position @ rest / squared[modes:]
        damping = kept.T @ self.damping @ kept
        force = kept.T @ self.force
        c = np.hstack(
            [by_position @ kept, by_rate @ kept - follows @ (rest.T @ self.damping @ kept)],
        )
        names = [f"mode_{k + 1}" for k in range(modes)]
        still = kept.T @ self.mass
        a, b = state_space(np.eye(modes), damping, np.diag(squared[:modes]), force)
        return LinearModel(
            a,
            b,
            c,
            self.D + follows @ (rest.T @ self.force),
            (*names, *(f"{name}_rate" for name in names)),
            self.input_names,
            self.output_names,
            self.position,
            self.torque,
            block_diag(still, still) @ self.state,
            self.output,
            np.eye(modes),
            damping,
            np.diag(squared[:modes]),
            force,
        )

    def to_control(self) -> Any:
        """The model as a `control.StateSpace` of the python-control library.

        Raises
        ------
        ImportError
            where that library is not installed
        """
        try:
            import control
        except ImportError:
            raise ImportError("python-control is not installed; pip install control") from None
        return control.ss(
            self.A,
            self.B,
            self.C,
            self.D,
            states=list(self.state_names),
            inputs=list(self.input_names),
            outputs=list(self.output_names),
        )

    def save(self, path: str | Path) -> None:
        """Write every attribute into a .npz file, for `load` and numpy.load."""
        with Path(path).open("wb") as file:
            arrays: dict[str, Any] = {f.name: np.asarray(getattr(self, f.name)) for f in fields(self)}
            np.savez_compressed(file, **arrays)

    @classmethod
    def load(cls, path: str | Path) -> LinearModel:
        """Read a file that `save` has written."""
        with np.load(path, allow_pickle=False) as file:
            missing = [f.name for f in fields(cls) if f.name not in file]
            if missing:
                raise ValueError(f"{path}: has no {missing[0]}; give a file written by LinearModel.save")
            found = {f.name: file[f.name] for f in fields(cls)}
        for name in ("state_names", "input_names", "output_names"):
            found[name] = tuple(str(word) for word in found[name])
        return cls(**found)

    def _rate_scale(self) -> np.ndarray:
        """(2n,) scale of the states that brings displacements and rates to one size."""
        n = len(self.mass)
        highest = np.sqrt(max(np.abs(self.A[n:, :n]).max(initial=0.0), 1.0))
        return np.concatenate([np.ones(n), np.full(n, highest)])


def linearize(
    scene: Scene,
    position: np.ndarray | list[float],
    outputs: Sequence[str] = ("joint_position", "joint_velocity"),
    held: Sequence[str] = (),
) -> LinearModel:
    """Linearise a scene about the static equilibrium at `position`, under the torques that hold it there.

    Parameters
    ----------
    position : (m,) joint coordinates, as the encoders show them, rad or m
    outputs : any of joint_position, joint_velocity, joint_acceleration; tip_position, tip_velocity,
        tip_acceleration (base frame); node_position, node_displacement.  `tip_position:link_1` is that of
        another link's end, `node_displacement:link_1/2` of one node.  Any sensor of the scene, too
    held : names of joints whose motors stand still; they are neither states nor inputs

    Inputs are the torques of the actuated joints that are not held.  Of a robot with loops the states are as
    many of the unknowns as are independent, passive joints last; the others follow.

    All effects of the scene are in it: gravity and the stiffness of its loads, Rayleigh's damping, friction
    (Coulomb's with its slope at standstill), rotors.  The unknowns are those that `simulate` integrates; a
    planar scene stays in its plane.

    Raises
    ------
    ArithmeticError
        where there is no stable equilibrium with the joints held
    ValueError
        for a position of the wrong size, or outputs that don't exist
    """
    fixed = sorted({joint_index(scene, name) for name in held})
    model = build_model(decided(scene), driven=tuple(held))
    q = check_position(scene, position)
    turned = model.turned
    moving = np.setdiff1d(np.arange(model.unknowns), turned[fixed])
    motors = np.setdiff1d(np.flatnonzero(model.actuated), fixed)
    ways = np.eye(model.unknowns)[:, moving]  # how all unknowns move with the states
    if scene.loops:
        assembly = Assembly(model)
        x0, push = assembly.rest(unknowns_at(model, q), model.actuated)
        moving, ways = assembly.independent(x0, moving)
        torque = -assembly.force(x0, push)[turned]
        stiffness = assembly.stiffness(x0, push)
    else:
        x0 = rest_shape(model, q)
        torque = -forces(model, x0)[turned]
        stiffness = stiffness_matrix(model, x0)
    stiffness = ways.T @ stiffness @ ways
    mass = ways.T @ mass_matrix(model, x0) @ ways
    damping = ways.T @ damping_matrix(model, x0) @ ways
    force = ways.T @ torque_directions(model)[:, motors]
    a, b = state_space(mass, damping, stiffness, force)
    n = len(moving)
    names, output, jacobians = linear_outputs(model, x0, outputs)
    by_position, by_rate, by_acceleration = (j @ ways for j in jacobians)
    c = np.hstack([by_position, by_rate]) + by_acceleration @ a[n:]
    rows = unknown_names(model)
    states = [rows[k] for k in moving]
    inputs = [scene.joint_names[k] for k in motors]
    return LinearModel(
        a,
        b,
        c,
        by_acceleration @ b[n:],
        (*states, *(f"{name}_rate" for name in states)),
        tuple(f"torque/{name}" for name in inputs),
        names,
        model.shown(x0),
        torque[motors],
        np.concatenate([x0[moving], np.zeros(n)]),
        output,
        mass,
        damping,
        stiffness,
        force,
    )


def state_space(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A (2n, 2n) and B (2n, i) of M q'' + damping q' + stiffness q = force u."""
    n = len(mass)
    inverse = cho_factor(mass)
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:, :n], a[n:, n:] = -cho_solve(inverse, stiffness), -cho_solve(inverse, damping)
    return a, np.vstack([np.zeros_like(force), cho_solve(inverse, force)])


def torque_directions(model: Model) -> np.ndarray:
    """(n, m) generalized force of a unit torque of each motor."""
    directions = np.eye(model.unknowns)[:, model.turned]
    own = np.flatnonzero((model.turn >= 0) & (model.motor < 0))
    directions[model.turn[own], own] = 1.0
    return directions


def unknown_names(model: Model) -> list[str]:
    """(n,) joints by name, their own elastic rotations, nodal dofs as link/node/component in beam axes.

    The modes of a reduced link are link/mode_1 and so on.
    """
    names = [""] * model.unknowns
    for k, joint in enumerate(model.scene.joint_names):
        names[k] = joint
        if model.turn[k] >= 0:
            names[model.turn[k]] = f"{joint}/turn"
        if model.motor[k] >= 0:
            names[k], names[model.motor[k]] = f"{joint}/link", joint
    chain = model.chain
    components = CO_MOVING_COMPONENTS if chain.co_moving else COMPONENTS
    for n, link in enumerate(model.scene.links):
        first, end = chain.link[n, FIRST], chain.link[n, FIRST] + chain.link[n, COUNT] + 1
        nodes = model.node_names[model.first_node[n] : model.first_node[n + 1]]
        for node, row in zip(nodes if chain.reduced[n, MODES] < 0 else nodes[:: len(nodes) - 1],
                             chain.unknown[first:end], strict=True):  # fmt: skip
            for dof, k in zip(chain.dofs, row, strict=True):
                if k >= 0:
                    names[k] = f"{node}/{components[dof]}"
        modes = chain.unknown[end : end + chain.reduced[n, ROWS]].ravel()
        for mode, k in enumerate(modes[modes >= 0]):
            names[k] = f"{link.name}/mode_{mode + 1}"
    return names
