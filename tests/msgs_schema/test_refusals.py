"""Whatever stands wrongly in a scene of a robot or a door is refused in the words of the scene's keys."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from typing import Any

import pytest

import flexsim_node
import thermal_node

WRONG: tuple[Any, ...] = (
    "x", "", 7, -3, 2.5, 1e9, True, None, float("nan"), [], [1], ["x"], [[1.0]], [1, 2, 3, 4], {}, {"x": 1},
    [{"x": 1}],
)  # fmt: skip
RAW = re.compile(
    r"[Ii]nput should|valid |dictionar|instance of|[Tt]uple|\bitems?\b|validation|pydantic|[Ee]xtra inputs|"
    r"[Ff]ield required|\[type=|function-|literal\[|Assertion"
)
"""What pydantic says, and no user has asked for."""

BEAM = {"width": 0.03, "depth": 0.01, "density": 7800.0, "youngs_modulus": 2.0e11, "elements": 2}
ROBOT: dict[str, Any] = {
    "model": "robot",
    "name": "arm",
    "gravity": [0.0, -9.81, 0.0],
    "damping": {"alpha": 2.0, "beta": 5.0e-4, "alpha_form": "elastic"},
    "links": [
        {"name": "first", "dh": {"a": 0.5}, "joint": {"name": "one", "effort_limit": 5.0}, "beam": BEAM},
        {
            "name": "second",
            "parent": "first",
            "dh": {"a": 0.4},
            "joint": {"name": "two", "rotor_inertia": 0.1, "gear_ratio": 2.0, "stiffness": 100.0},
            "beam": BEAM,
            "flexible": True,
            "reduction": {"modes": 2},
            "payload": {
                "mass": 0.5,
                "center_of_mass": [0.0, 0.0, 0.0],
                "inertia": [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.2]],
            },
        },
    ],
    "erls": {"zeroed": [{"link": name, "node": 0, "dof": "rz"} for name in ("first", "second")]},
    "initial": {"position": {"one": 0.0}, "velocity": [0.0, 0.0], "shape": "undeformed"},
    "effects": {"gravity": True, "shear": "auto"},
    "auto": {"margin": 2.0, "beyond": "warn"},
    "validity": {"elastic_rotation": {"warn": 0.1, "stop": 0.5}},
    "solver": {"method": "rosenbrock_w", "step": 1e-3},
    "sensors": [{"name": "gauge", "type": "strain_gauge", "link": "first", "fraction": 0.5, "side": "+y"}],
    "torque": [{"joint": "one", "type": "table", "time": [0.0, 1.0], "value": [0.0, 1.0]}],
    "duration": 1.0,
    "tolerance": 1e-4,
    "tip": "second",
    "faults": [{"kind": "noise", "signal": "effort", "deviation": 0.1, "joints": ["one"]}],
    "seed": 1,
}  # fmt: skip
TABLE = {"temperature": [20.0, 500.0, 1000.0], "value": [0.04, 0.1, 0.2], "beyond": "hold"}
DOOR: dict[str, Any] = {
    "model": "fire_door",
    "name": "door",
    "leaf": {
        "height": 2.0,
        "width": 1.0,
        "layers": [
            {"material": "steel", "thickness": 0.001},
            {"material": "wool", "thickness": 0.03, "contact_resistance": 0.01},
            {"cavity": 0.02, "emissivity": [0.9, 0.3], "convection": "still"},
            {"material": "board", "thickness": 0.01},
        ],
        "rim": {"material": "steel", "thickness": 0.001, "contact": 0.5},
    },
    "materials": {
        "wool": {
            "density": 100.0,
            "specific_heat": 1000.0,
            "conductivity": TABLE,
            "oxygen_diffusivity": 2.05e-5,
            "reactions": [
                {
                    "name": "binder", "share": 0.05, "residue": 0.2, "heat_of_combustion": 2.5e7,
                    "oxygen": "diffusion",
                    "kinetics": {"frequency_factor": 0.05, "activation_energy": 2.0e4, "order": 0.7},
                },
                {
                    "name": "size", "share": 0.01, "latent_heat": 2.0e6,
                    "rate": {"temperature": [20.0, 500.0], "value": [0.0, 0.01]},
                },
            ],
        },
        "board": {
            "density": 800.0,
            "specific_heat": TABLE | {"value": [900.0, 950.0, 1000.0]},
            "conductivity": 0.2,
            "moisture": {"share": 0.01, "temperature": [100.0, 120.0]},
            "reactions": [
                {
                    "name": "dry", "share": 0.15, "latent_heat": 3.0e6,
                    "temperature": [100, 150], "degree": [0, 1],
                },
            ],
        },
    },
    "furnace": {
        "curve": "measured",
        "time": [0.0, 30.0, 60.0],
        "thermocouples": [[20.0, 100.0, 200.0], [20.0, None, 220.0]],
        "longest_gap": 60.0,
        "burners": {"count": 4, "power": 5e5},
        "radiation": {"temperature": [20.0, 500.0], "time": [0.0, 60.0]},
    },
    "exposed": {"film_coefficient": 25.0, "emissivity": 0.7, "flux": {"time": [0, 60], "value": [0.0, 10.0]}},
    "unexposed": {"film_coefficient": 10.0, "held": False, "gas": "ambient"},
    "lateral": {"film_coefficient": 10.0, "depth": 0.01},
    "ambient": 20.0,
    "initial": 20.0,
    "mesh": {"in_plane": [20, 40], "layers": [1, 5, 1, 5], "symmetry": "quarter", "first_brick": 0.0025},
    "solver": {"model": "full", "step": 5.0, "method": "tr_bdf2", "tolerance": 0.03},
    "probes": {"sets": ["thesis", "ftp"], "points": {"mine": {"x": 0.1, "y": 0.2}}},
    "criteria": {"standard": ["ftp_a", "en_1634"], "minutes": 60.0, "points": ["mine"], "gap": 0.006},
    "seals": {"bridged": 0.008, "until": 2400.0},
    "deformation": {
        "model": "none",
        "hinges": [-0.8, {"height": 0.8, "play": 0.001, "stiffness": 1e6}],
        "lock": [{"height": 0.0, "across": 0.4}],
        "opens": "towards_fire",
        "stop": {"edges": ["top"], "clearance": 0.001},
        "in_plane": [16, 32],
        "layers": [1, 1, 1, 1],
    },
}  # fmt: skip
SCENES = {"robot": (flexsim_node.load_scene, ROBOT), "door": (thermal_node.load_scene, DOOR)}


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every key and entry below a document."""
    below = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in below:
        yield (*path, key)
        yield from places(inner, (*path, key))


def around(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path[:-1]:
        document = document[key]
    return document


def mistakes(right: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The scene with one thing wrong: another value, a key that is missing, one that nobody knows."""
    for path in places(right):
        for wrong in WRONG:
            scene = copy.deepcopy(right)
            around(scene, path)[path[-1]] = wrong
            yield scene
        scene = copy.deepcopy(right)
        here = around(scene, path)
        del here[path[-1]]
        yield scene
        if isinstance(here, dict):
            here["nobody_knows_this"] = 1
            yield scene


@pytest.mark.parametrize("kind", SCENES)
def test_no_refusal_speaks_of_how_scenes_are_checked(kind: str) -> None:
    """What, where, and what would be right, in one line and in the scene's own words."""
    load, right = SCENES[kind]
    load(copy.deepcopy(right))
    refused = 0
    for scene in mistakes(right):
        try:
            load(scene)
        except ValueError as problem:
            said = str(problem)
            refused += 1
            assert "\n" not in said and not RAW.search(said), said
            assert said.startswith("scene: ") and said.count(": ") >= 2, said
    assert refused > 1500
