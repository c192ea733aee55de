"""What a user asks of the kept states of a run, all of them in one call without Python's lock."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numba import types

from ..compiled.by_address import address, by_address, image
from ..compiled.kernel import kernel
from ..equations.dynamics.energy import energy
from ..sensors.observation import observe
from .simulation import Simulation

NUMBERS = types.Array(types.int64, 1, "C")
VECTOR, MATRIX, TENSOR = (types.Array(types.float64, d, "C") for d in (1, 2, 3))
observe_at = by_address(
    types.none, types.voidptr, types.voidptr, TENSOR, NUMBERS, VECTOR, VECTOR, MATRIX, MATRIX, MATRIX, MATRIX
)
energy_at = by_address(types.none, types.voidptr, types.voidptr, VECTOR, VECTOR, VECTOR)

JOINTS = ("joint_position", "joint_velocity")
PLACES = ("link_end", "node_position", "rigid_position", "node_displacement")


@kernel
def observe_all(at, chain, work, axes, shown, station, states, count, position, rigid, displacement, pose):
    """Observe the first states (K, 2, n), each into its own row."""
    for k in range(count):
        observe_at(
            at, chain, work, axes, shown, station, states[k, 0], position[k], rigid[k], displacement[k], pose
        )


@kernel
def energy_all(at, chain, work, states, count, parts, out):
    """Energy (K,), J, of the first states (K, 2, n)."""
    for k in range(count):
        energy_at(at, chain, work, states[k, 0], states[k, 1], parts)
        out[k] = parts[0] + parts[1] + parts[2]


class Samples:
    """Reads states of one robot; its results are in buffers that the next call overwrites."""

    def __init__(self, robot: Simulation, asked: Iterable[str]) -> None:
        self.robot, self.asked = robot, tuple(asked)
        view, model = robot.view, robot.model
        chain, work = model.chain, robot.work
        self.nodes = len(view.position)
        self.fixed = (model.axes, model.first_node, model.station)
        self.tied = (image(chain), image(work))
        self.observe: Any = address(
            observe, chain, work, *self.fixed, robot.x, view.position, view.rigid_position, view.displacement,
            view.pose,
        )  # fmt: skip
        self.energy: Any = address(energy, chain, work, robot.x, robot.v, robot.energies)
        self.places = np.zeros((0, 0, 3)), np.zeros((0, 0, 3)), np.zeros((0, 0, 6))
        self.energies = np.zeros(0)

    def read(self, states: np.ndarray, count: int) -> dict[str, np.ndarray]:
        """What was asked of the first `count` states (K, 2, n), by name, each (count, ...)."""
        robot, model, found = self.robot, self.robot.model, {}
        for row, name in enumerate(JOINTS):
            if name in self.asked:
                found[name] = model.shown(states[:count, row].T).T
        if any(name in self.asked for name in PLACES):
            if len(self.places[0]) < count:
                self.places = tuple(np.zeros((len(states), self.nodes, d)) for d in (3, 3, 6))  # type: ignore[assignment]
            position, rigid, displacement = self.places
            observe_all(self.observe, *self.tied, *self.fixed, states, count, *self.places, robot.view.pose)
            all_of = (
                position[:count, robot.view.ends],
                position[:count],
                rigid[:count],
                displacement[:count],
            )
            found |= {name: values for name, values in zip(PLACES, all_of, strict=True) if name in self.asked}
        if "energy" in self.asked:
            if len(self.energies) < count:
                self.energies = np.zeros(len(states))
            energy_all(self.energy, *self.tied, states, count, robot.energies, self.energies)
            found["energy"] = self.energies[:count]
        return found
