"""Static equilibrium: the shape and the torques that hold a robot still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .chain import workspace
from .dynamics import residual
from .factorization import factorize, set_scale, solve
from .kinematics import place
from .model import Model, build_model
from .observation import Observation
from .scene import Scene

ITERATIONS = 200


@dataclass(frozen=True)
class StaticEquilibrium:
    """A robot at rest.

    Attributes
    ----------
    torque : (m,) that holds the joints, N m or N
    node_displacement : (N, 6) in link frames, m and rad
    node_position : (N, 3), link_end : (L, 3) in the base frame, m
    """

    torque: np.ndarray
    node_displacement: np.ndarray
    node_position: np.ndarray
    link_end: np.ndarray


def rest_shape(model: Model, position: np.ndarray) -> np.ndarray:
    """Unknowns (n,) of the equilibrium with the joint coordinates held at position (m,)."""
    work = workspace(model.chain)
    work.held[:] = True
    m, n = model.joints, model.unknowns
    x, zero, rhs, dx = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    x[:m] = position
    # stiffness outweighs the mass by far: Newton's method with the elastic stiffness
    weight = 1e8
    set_scale(model.chain, work, weight, 0.0)
    best = np.inf
    for _ in range(ITERATIONS):
        residual(model.chain, work, x, zero, zero, np.zeros(m), rhs)
        place(model.chain, work, x)
        if n == m or factorize(model.chain, work) != 0:
            break
        solve(model.chain, work, rhs, dx)
        x[m:] += weight * dx[m:]
        size = float(np.max(np.abs(weight * dx[m:])))
        if size < 1e-15 or (size < 1e-11 and size >= best):
            return x
        best = min(best, size)
    if n == m:
        return x
    raise ArithmeticError(
        f"{model.scene.name}: no static equilibrium found at {np.round(position, 6).tolist()};"
        " the links are too soft for their load, or buckle"
    )


def static_equilibrium(scene: Scene, position: np.ndarray | list[float]) -> StaticEquilibrium:
    """Shape and holding torques with the joints at `position` (m,).

    Raises
    ------
    ArithmeticError
        where no equilibrium is found (the links buckle under their load)
    """
    model = build_model(scene)
    m, n = model.joints, model.unknowns
    q = check_position(scene, position, m)
    x = rest_shape(model, q)
    work, rhs, zero = workspace(model.chain), np.zeros(n), np.zeros(n)
    residual(model.chain, work, x, zero, zero, np.zeros(m), rhs)
    view = Observation(model)
    view.look(work, x)
    return StaticEquilibrium(-rhs[:m], view.displacement, view.position, view.link_end)


def check_position(scene: Scene, position: np.ndarray | list[float], m: int) -> np.ndarray:
    """Joint coordinates as an array (m,), or a ValueError that says what is wrong."""
    q = np.asarray(position, dtype=float).reshape(-1)
    if q.shape != (m,) or not np.all(np.isfinite(q)):
        raise ValueError(f"{scene.name}: position {position!r}; give {m} finite joint coordinates")
    return q
