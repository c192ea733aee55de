"""Hard loads: what weight and spin do to the stiffness of what carries them, against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexsim_node import load_scene, natural_frequencies, simulate, static_equilibrium
from flexsim_node.elements.section import torsion_constant

from .case import STEEL, Case, Outcome, Scene, arm, bar, finite, planar
from .motions import spin

G = 9.81
LIGHT = 10.001  # kg/m3, next to nothing beside what the beams carry
POINT = [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]]  # kg m2


def column(length: float, bending: float, pull: float) -> np.ndarray:
    """(2, 2) stiffness of a massless cantilever's end (deflection, rotation) under a pull, N; a push below 0.

    w = A (cosh kx - 1) + B (sinh kx - kx) solves EI w'''' = N w''; of a push k is imaginary.
    """
    k = np.sqrt(complex(pull / bending))
    x = k * length
    end = np.array([[np.cosh(x) - 1, np.sinh(x) - x], [k * np.sinh(x), k * (np.cosh(x) - 1)]])
    moment = bending * k**2 * np.array([np.cosh(x), np.sinh(x)])
    force = -bending * k**3 * np.array([np.sinh(x), np.cosh(x)]) + pull * end[1]
    return np.real(np.array([force, moment]) @ np.linalg.inv(end))


def with_body(stiffness: np.ndarray, mass: float, beyond: float, pull: float, inertia: float) -> float:
    """First frequency, Hz, of a body whose centre is `beyond` the end, pulled outwards."""
    lever = np.array([1.0, beyond])
    stiffness = stiffness + np.diag([0.0, pull * beyond])
    squared = np.linalg.eigvals(
        np.linalg.solve(mass * np.outer(lever, lever) + np.diag([0, inertia]), stiffness)
    )
    return float(np.sqrt(np.min(squared.real)) / (2 * np.pi))


def found(right: float, value: float, allowed: float) -> Outcome:
    off = abs(value - right) / right
    return Outcome(off <= allowed, "ok", {"frequency, Hz": value, "right": right, "off": off})


def first(scene: Scene, position: list[float], **keys: Any) -> float:
    return float(natural_frequencies(load_scene(scene), position, **keys)[0])


def unstable(scene: Scene, position: list[float]) -> Outcome:
    """No stable equilibrium is found, and that is said."""
    try:
        value = first(scene, position, loaded=True)
    except ArithmeticError as said:
        return Outcome("buckle" in str(said), f"refused: {said}")
    return Outcome(value == 0.0, "was not refused", {"frequency, Hz": value})


# A rod along x that twists; the body stands on its end, or hangs from it.
ROD, SIDE, ALUMINIUM, NU, BODY = 0.5, 0.006, 7e10, 0.3, 1.0
TWIST = ALUMINIUM / (2 * (1 + NU)) * torsion_constant(SIDE, SIDE) / ROD  # N m/rad


def rod(height: float) -> Scene:
    beam = {"width": SIDE, "depth": SIDE, "density": LIGHT, "youngs_modulus": ALUMINIUM, "poissons_ratio": NU}
    body = {"mass": BODY, "center_of_mass": [0.0, height, 0.0], "inertia": POINT}
    return planar(bar("rod", ROD, beam=beam, payload=body), effects={"bending_y": False, "bending_z": False})


def body_on_rod(height: float) -> Outcome:
    right = np.sqrt((TWIST - BODY * G * height) / (BODY * height**2 + 1e-6)) / (2 * np.pi)
    return found(right, first(rod(height), [0.0], loaded=True), 5e-3)


# A column along z whose outer links are rigid and stand on it, or hang from its end.
SOFT = {"density": LIGHT, "youngs_modulus": 9e9, "width": 0.03, "depth": 0.01, "elements": 4}


def rigid_outer(up: bool, **stiff: Any) -> Scene:
    scene = arm(gravity=[0.0, 0.0, -G], initial={"position": [0.0, 0.5 * np.pi if up else -0.5 * np.pi, 0.0]})
    scene["links"][0]["beam"] = SOFT
    for link in scene["links"][1:]:
        link["flexible"] = bool(stiff)
        link["beam"] = {**STEEL, **stiff}
    return scene


def hanging_or_standing(up: bool) -> Outcome:
    mass = 7800.0 * 0.01 * 0.03 * 1.0
    scene = rigid_outer(up)
    bending = 9e9 * 0.03 * 0.01**3 / 12
    beyond = 0.5 if up else -0.5
    inertia = mass * (1.0 + 0.01**2) / 12  # about the axis that the softer side of the column turns it by
    stiffness = column(0.5, bending, -mass * G)
    right = with_body(stiffness, mass, beyond, -mass * G, inertia)
    return found(right, first(scene, scene["initial"]["position"], loaded=True), 5e-3)


def rigid_or_nearly() -> Outcome:
    """A link said to be rigid is one of a very stiff material."""
    where = rigid_outer(True)["initial"]["position"]
    rigid = first(rigid_outer(True), where, loaded=True)
    stiff = first(rigid_outer(True, youngs_modulus=1e14), where, loaded=True)
    return found(stiff, rigid, 1e-3)


# A strip on its edge with a weight at its end.
STRIP, HIGH, THIN = 0.6, 0.04, 0.001
LATERAL = (
    4.0126 / STRIP**2 * np.sqrt(2e11 * HIGH * THIN**3 / 12 * 2e11 / 2.6 * torsion_constant(HIGH, THIN))
)  # N, Timoshenko & Gere, Theory of Elastic Stability, 6.3


def strip(share: float) -> Scene:
    beam = {"width": HIGH, "depth": THIN, "density": LIGHT, "elements": 16}
    return planar(bar("strip", STRIP, beam=beam, payload={"mass": share * LATERAL / G}))


def lateral_below() -> Outcome:
    """The frequency times the root of the mass is the root of what stiffness is left."""
    free, near = (first(strip(share), [0.0], loaded=True) * np.sqrt(share) for share in (1e-3, 0.97))
    left = near / free
    return Outcome(0.0 < left < 0.35, "ok", {"frequency left at 0.97 of the critical weight": left})


# A strip that spins in the plane and carries a body beyond its end.
HUB, BEYOND, CARRIED, FLAT, DEEP = 0.5, 0.25, 0.5, 0.004, 0.03


def spun(**keys: Any) -> Scene:
    beam = {"width": FLAT, "depth": DEEP, "density": LIGHT, "elements": 8, "youngs_modulus": 7e10}
    body = {"mass": CARRIED, "center_of_mass": [BEYOND, 0.0, 0.0], "inertia": POINT}
    strip = bar("strip", HUB, beam=beam, payload=body, joint={"name": "hub"})
    return planar(strip, **{"gravity": [0.0, 0.0, 0.0], **keys})


def spun_frequency(rate: float) -> Outcome:
    """In the plane of the spin the centrifugal force also pulls sideways, with m w^2 of the sidestep."""
    pull = CARRIED * rate**2 * (HUB + BEYOND)
    lever = np.array([1.0, BEYOND])
    stiffness = column(HUB, 7e10 * DEEP * FLAT**3 / 12, pull) - CARRIED * rate**2 * np.outer(lever, lever)
    right = with_body(stiffness, CARRIED, BEYOND, pull, 1e-6)
    return found(right, first(spun(), [0.0], velocity=[rate]), 1e-2)


def spun_motion() -> Outcome:
    """At 60 rad/s it swings about the radius, and no further than when it was spun up."""
    scene = spun(damping={"alpha": 0.0, "beta": 1e-4})
    run = simulate(load_scene(scene), duration=4.0, sample_period=0.01, prescribed={"hub": spin(60.0, 2.0)})
    late = np.abs(run.node_displacement[run.time > 3.0, -1, 1])
    size = float(np.max(late, initial=0.0))
    return Outcome(
        run.status == "ok" and finite(run) and size < 0.02, run.status, {"late deflection, m": size}
    )


def upright(share: float) -> Scene:
    """A column under a weight at its end, as a share of Euler's load."""
    beam = {"density": LIGHT, "width": 0.004, "depth": 0.03, "elements": 8}
    load = np.pi**2 * 2e11 * 0.03 * 0.004**3 / 12 / (4 * 0.5**2)
    return planar(bar("column", 0.5, beam=beam, payload={"mass": share * load / G}))


def euler_below() -> Outcome:
    scene = upright(0.97)
    mass = scene["links"][0]["payload"]["mass"]
    right = with_body(column(0.5, 2e11 * 0.03 * 0.004**3 / 12, -mass * G), mass, 0.0, 0.0, 1e-12)
    return found(right, first(scene, [0.5 * np.pi], loaded=True), 1e-2)


def wire() -> Outcome:
    """A body on a wire swings as a pendulum, a little faster for the wire's stiffness."""
    beam = {"density": LIGHT, "width": 0.001, "depth": 0.001, "elements": 16}
    scene = planar(bar("wire", 0.5, beam=beam, payload={"mass": 10.0}))
    k = np.sqrt(10.0 * G / (2e11 * 0.001**4 / 12))
    right = np.sqrt(G * k / (k * 0.5 - np.tanh(k * 0.5))) / (2 * np.pi)
    return found(right, first(scene, [-0.5 * np.pi], loaded=True), 5e-3)


def reduced_under_load() -> Outcome:
    """A heavy body on a slender link that is reduced to six modes, against all of its elements."""
    beam = {"density": 1000.0, "width": 0.003, "elements": 8}
    scene = planar(bar("link", 0.5, beam=beam, payload={"mass": 20.0}))
    full = first(scene, [-0.5 * np.pi], loaded=True)
    return found(full, first({**scene, "reduction": {"modes": 6}}, [-0.5 * np.pi], loaded=True), 1e-2)


def moment_on_soft_end() -> Outcome:
    """A moment bends a cantilever to an arc of a circle."""
    turn, stiffness = 0.08, 2e9 * 0.03 * 0.01**3 / 12
    moment = turn * stiffness / 0.5
    scene = planar(
        bar("link", 0.5, beam={"youngs_modulus": 2e9, "elements": 4}),
        gravity=[0.0, 0.0, 0.0],
        damping={"alpha": 0.0, "beta": 0.02},
    )
    run = simulate(
        load_scene(scene),
        duration=2.0,
        sample_period=0.05,
        prescribed={"link_joint": lambda t: (0.0, 0.0, 0.0)},
        wrench={"base:link": lambda t: np.array([0.0, 0.0, 0.0, 0.0, 0.0, moment])},
    )
    right = 0.5 / turn * np.array([np.sin(turn), 1.0 - np.cos(turn)])
    off = float(np.max(np.abs(run.link_end[-1, 0, :2] - right)))
    return Outcome(run.status == "ok" and off < turn**3, run.status, {"off the arc, m": off})


def far_slide() -> Outcome:
    """The first motor holds the weight at its lever, 30 m out."""
    body = {"mass": 2.0, "inertia": np.diag([0.01, 0.01, 0.01]).tolist()}
    quarter = 0.5 * np.pi
    scene = {
        "model": "robot",
        "name": "hard",
        "gravity": [0.0, -G, 0.0],
        "links": [
            {"name": "turn", "dh": {"alpha": quarter}, "rigid": body},
            {"name": "slide", "dh": {"d": 0.2}, "joint": {"type": "prismatic"}, "rigid": body},
        ],
    }
    # with theta = 90 degrees the slide points along x
    torque = static_equilibrium(load_scene(scene), [quarter, 30.0]).torque
    right = 2.0 * G * 30.2
    off = abs(float(torque[0]) - right) / right
    return Outcome(off < 1e-12, "ok", {"torque, N m": float(torque[0]), "off": off})


def heavy_motor() -> Outcome:
    """A rotor of 400 kg m2 at the joint and a light link swing against each other through a soft spring."""
    joint = {"rotor_inertia": 0.04, "gear_ratio": 100.0, "stiffness": 50.0}
    body = {"mass": 0.1, "center_of_mass": [-0.1, 0.0, 0.0]}
    scene = planar({"name": "link", "dh": {"a": 0.3}, "joint": joint, "rigid": body}, gravity=[0.0, 0.0, 0.0])
    link = 0.1 * 0.2**2
    right = np.sqrt(50.0 * (1 / link + 1 / 400.0)) / (2 * np.pi)
    return found(right, float(natural_frequencies(load_scene(scene), [0.0], locked=False)[-1]), 1e-9)


CASES = [
    Case(
        "body_above_twisting_rod",
        "its weight takes stiffness from the rod's twist, to second order of it",
        "frequency of (GJ/L - m g h) / I to 0.5 %",
        lambda: body_on_rod(0.3),
    ),
    Case(
        "body_below_twisting_rod",
        "its weight adds stiffness to the rod's twist",
        "frequency of (GJ/L + m g h) / I to 0.5 %",
        lambda: body_on_rod(-0.3),
    ),
    Case(
        "body_above_beyond_torsion",
        "m g h above GJ/L: the body falls over, and nothing is bent before it does",
        "no stable equilibrium, and that is said",
        lambda: unstable(rod(1.2 * TWIST / (BODY * G)), [0.0]),
    ),
    Case(
        "rigid_links_standing",
        "rigid outer links stand on a soft column: their weight turns with its end",
        "first frequency of a column with a body on it, to 0.5 %",
        lambda: hanging_or_standing(True),
    ),
    Case(
        "rigid_links_hanging",
        "the same links hang from the column's end and press it all the same",
        "first frequency of a column with a body below its end, to 0.5 %",
        lambda: hanging_or_standing(False),
    ),
    Case(
        "rigid_or_1e14",
        "one link, said to be rigid or given a modulus of 1e14",
        "the same loaded frequency to 0.1 %",
        rigid_or_nearly,
    ),
    Case(
        "strip_below_lateral_buckling",
        "a deep strip at 0.97 of the weight under which it tips sideways, hardly bent",
        "stable, and less than 35 % of its frequency left",
        lateral_below,
    ),
    Case(
        "strip_above_lateral_buckling",
        "the same strip at 1.03 of that weight: twist and sideways bending buckle together",
        "no stable equilibrium, and that is said",
        lambda: unstable(strip(1.03), [0.0]),
    ),
    Case(
        "spun_body_40",
        "a body 0.25 m beyond the end of a strip at 40 rad/s: its centrifugal force holds it",
        "frequency of a beam under that pull, to 1 %",
        lambda: spun_frequency(40.0),
    ),
    Case(
        "spun_body_60",
        "the same at 60 rad/s, above the strip's own frequency",
        "frequency of a beam under that pull, to 1 %",
        lambda: spun_frequency(60.0),
    ),
    Case(
        "spun_body_in_motion",
        "spun up to 60 rad/s, where it is stable only by what the pull does to the body",
        "swings within 2 cm of the radius",
        spun_motion,
    ),
    Case(
        "euler_below",
        "a column at 0.97 of Euler's load: a sixth of its frequency is left",
        "frequency of a pressed beam, to 1 %",
        euler_below,
    ),
    Case(
        "euler_above",
        "the same column at 1.03 of Euler's load",
        "no stable equilibrium, and that is said",
        lambda: unstable(upright(1.03), [0.5 * np.pi]),
    ),
    Case(
        "body_on_a_wire",
        "the weight stiffens the wire some hundred times",
        "frequency of a pulled beam, to 0.5 %",
        wire,
    ),
    Case(
        "reduced_under_load",
        "a reduced link's few modes must take up the pull of a heavy body",
        "first frequency of all its elements, to 1 %",
        reduced_under_load,
    ),
    Case(
        "moment_on_soft_end",
        "a moment turns the end of a soft link by 0.08 rad",
        "its end lies on the circle's arc to the cube of that",
        moment_on_soft_end,
    ),
    Case(
        "slide_30_m_out",
        "a prismatic joint a hundred times its link's length out",
        "holding torque is weight times lever, to 1e-12",
        far_slide,
    ),
    Case(
        "motor_1e5_heavier",
        "a rotor a hundred thousand times the link's inertia behind a soft spring",
        "frequency of both on the spring, to 1e-9",
        heavy_motor,
    ),
]
