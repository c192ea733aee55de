"""What a linear model can be asked to show, and how it depends on the unknowns, rates and accelerations."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence

import numpy as np

from ..equations.dynamics.tangent import differences
from ..model.chain import workspace
from ..model.model import Model
from ..sensors.instruments import Sensors
from ..sensors.observation import Observation

ORDERS = {"position": 0, "velocity": 1, "acceleration": 2}
AXES = ("x", "y", "z")
DISPLACEMENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
KNOWN = (
    *(f"joint_{order}" for order in ORDERS),
    *(f"tip_{order}" for order in ORDERS),
    "node_position",
    "node_displacement",
)
Placed = Callable[[np.ndarray], np.ndarray]  # what the unknowns (n,) look like


def linear_outputs(
    model: Model, x0: np.ndarray, outputs: Sequence[str]
) -> tuple[tuple[str, ...], np.ndarray, list[np.ndarray]]:
    """Names, values (p,) at rest at x0 (n,), derivatives (p, n) by unknowns, rates and accelerations."""
    if isinstance(outputs, str):
        outputs = (outputs,)
    names: list[str] = []
    values: list[np.ndarray] = []
    jacobians: list[list[np.ndarray]] = [[], [], []]
    for asked in outputs:
        if asked in sensor_names(model):
            rows, value, derivatives = sensor_output(model, x0, asked)
            names += rows
            values.append(value)
            for k in range(3):
                jacobians[k].append(derivatives[k])
            continue
        rows, order, placed = output(model, asked)
        # at rest a velocity is J(x0) v, an acceleration J(x0) a: what is quadratic in the rates vanishes
        by_unknowns = differences(placed, x0, np.eye(model.unknowns))
        value = np.array(placed(x0))
        names += rows
        values.append(value if order == 0 else np.zeros_like(value))
        for k in range(3):
            jacobians[k].append(by_unknowns if k == order else np.zeros_like(by_unknowns))
    empty = np.zeros((0, model.unknowns))
    stacked = [np.vstack([empty, *part]) for part in jacobians]
    return tuple(names), np.concatenate([np.zeros(0), *values]), stacked


def sensor_names(model: Model) -> list[str]:
    """Names of the scene's sensors."""
    return [sensor.name for sensor in model.scene.sensors]


def sensor_output(model: Model, x0: np.ndarray, name: str) -> tuple[list[str], np.ndarray, list[np.ndarray]]:
    """Names and values (p,) of a sensor at rest, and derivatives (p, n) by unknowns, rates, accelerations."""
    sensors, view, work = Sensors(model), Observation(model), workspace(model.chain)
    n = model.unknowns

    def read(motion: np.ndarray) -> np.ndarray:
        x, v, a = np.array(np.split(motion, 3))
        view.look(work, x)
        sensors.look(view, work, x, v, a)
        return sensors.values[name].copy()

    rest = np.concatenate([x0, np.zeros(2 * n)])
    derivatives = np.split(differences(read, rest, np.eye(3 * n)), 3, axis=1)
    letters = sensors.letters(name)
    rows = [name if len(letters) == 1 else f"{name}/{letter}" for letter in letters]
    return rows, read(rest), list(derivatives)


def output(model: Model, asked: str) -> tuple[list[str], int, Placed]:
    """Names, time derivative (0, 1, 2) and function of the unknowns of one output."""
    kind, _, place = asked.partition(":")
    if kind not in KNOWN:
        known = [*KNOWN, *sensor_names(model)]
        near = difflib.get_close_matches(kind, known, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"give any of {', '.join(known)}"
        raise ValueError(f"{model.scene.name}: no output {kind!r}; {hint}")
    what, _, word = kind.partition("_")
    order = ORDERS.get(word, 0)
    if what == "joint":
        if place and place not in model.scene.joint_names:
            raise ValueError(
                f"{model.scene.name}: output {asked!r}: no joint {place!r};"
                f" give one of {', '.join(model.scene.joint_names)}"
            )
        chosen = [k for k, name in enumerate(model.scene.joint_names) if place in ("", name)]
        names = [f"{kind}/{model.scene.joint_names[k]}" for k in chosen]
        return names, order, lambda x: model.shown(x)[chosen]
    view, work = Observation(model), workspace(model.chain)
    if what == "tip":
        links = [link.name for link in model.scene.links]
        if place and place not in links:
            raise ValueError(
                f"{model.scene.name}: output {asked!r}: no link {place!r}; give one of {', '.join(links)}"
            )
        at = view.ends[links.index(place) if place else -1]
        nodes = [int(at)]
        prefix = [kind if not place else asked]
    else:
        if place and place not in model.node_names:
            raise ValueError(
                f"{model.scene.name}: output {asked!r}: no node {place!r};"
                f" give one of {', '.join(model.node_names)}"
            )
        nodes = [k for k, name in enumerate(model.node_names) if place in ("", name)]
        prefix = [f"{kind}/{model.node_names[k]}" for k in nodes]
    bent = kind == "node_displacement"

    def placed(x: np.ndarray) -> np.ndarray:
        view.look(work, x)
        return (view.displacement if bent else view.position)[nodes].ravel()

    letters = DISPLACEMENTS if bent else AXES
    return [f"{before}/{letter}" for before in prefix for letter in letters], order, placed
