"""Rigid planar mechanisms by their closed-form kinematics, and loops of links for the tests."""

from __future__ import annotations

import numpy as np
from scenes import link, robot
from scipy.integrate import solve_ivp

PASSIVE = {"actuated": False}
WIDTH, DEPTH = 0.03, 0.01
CRANK, COUPLER, ROCKER, GROUND = 0.15, 0.4, 0.3, 0.35


def four_bar(beam=None, lengths=(CRANK, COUPLER, ROCKER, GROUND), **keys) -> dict:
    """A crank-rocker in a vertical plane; rigid links where no beam is given."""
    bends = {"flexible": False} if beam is None else {"beam": beam}
    a, b, c, d = lengths
    return robot(
        link("crank", {"a": a}, **bends),
        link("coupler", {"a": b}, joint=PASSIVE, **bends),
        link("ground", {"a": d}, None, joint={"type": "fixed"}, parent="base"),
        link("rocker", {"a": c}, joint=PASSIVE, **bends),
        **{
            "loops": [{"links": ["coupler", "rocker"]}],
            "gravity": [0.0, -9.81, 0.0],
            "initial": {"position": [0.7], "velocity": [8.0]},
            **keys,
        },
    )


def slider_crank(beam=None, slider=0.4, **keys) -> dict:
    """Crank and rod in a vertical plane; the rod's end, with the slider's mass, slides along x."""
    bends = {"flexible": False} if beam is None else {"beam": beam}
    return robot(
        link("crank", {"a": CRANK}, **bends),
        link("rod", {"a": COUPLER}, joint=PASSIVE, payload={"mass": slider}, **bends),
        **{
            "loops": [{"links": ["rod", "base"], "joint": "slot", "axis": {"base": [1.0, 0.0, 0.0]}}],
            "gravity": [0.0, -9.81, 0.0],
            "initial": {"position": [0.7], "velocity": [8.0]},
            **keys,
        },
    )


def bar(length: float) -> tuple[float, float]:
    """Mass and central moment of inertia of a rectangular steel bar turning in the plane of its width."""
    mass = 7800.0 * WIDTH * DEPTH * length
    return mass, mass * (length**2 + WIDTH**2) / 12.0


class FourBar:
    """Absolute angles of coupler and rocker by intersecting circles, their rates by the loop's derivative."""

    def angles(self, theta):
        """(coupler, rocker) at the crank's angle, the open branch."""
        pin = CRANK * np.exp(1j * theta)
        across = GROUND - pin
        inside = np.arccos((COUPLER**2 + abs(across) ** 2 - ROCKER**2) / (2 * COUPLER * abs(across)))
        coupler = np.angle(across) + inside
        return coupler, np.angle(pin + COUPLER * np.exp(1j * coupler) - GROUND)

    def ratios(self, theta):
        """Rates of coupler and rocker for a crank that turns at 1 rad/s."""
        psi, chi = self.angles(theta)
        return (
            CRANK * np.sin(theta - chi) / (COUPLER * np.sin(chi - psi)),
            CRANK * np.sin(theta - psi) / (ROCKER * np.sin(chi - psi)),
        )

    def inertia(self, theta):
        """Reduced to the crank, kg m2."""
        psi, _ = self.angles(theta)
        turn, swing = self.ratios(theta)
        (a, own_a), (b, own_b), (c, own_c) = bar(CRANK), bar(COUPLER), bar(ROCKER)
        middle = CRANK * np.exp(1j * theta) + 0.5 * COUPLER * turn * np.exp(1j * psi)
        return (
            own_a + 0.25 * a * CRANK**2 + b * abs(middle) ** 2 + own_b * turn**2
            + (own_c + 0.25 * c * ROCKER**2) * swing**2
        )  # fmt: skip

    def height(self, theta):
        """Potential energy in gravity along -y, J."""
        psi, chi = self.angles(theta)
        moments = (
            0.5 * bar(CRANK)[0] * CRANK * np.sin(theta)
            + bar(COUPLER)[0] * (CRANK * np.sin(theta) + 0.5 * COUPLER * np.sin(psi))
            + 0.5 * bar(ROCKER)[0] * ROCKER * np.sin(chi)
        )
        return 9.81 * moments


class SliderCrank:
    """x = r cos + sqrt(l^2 - r^2 sin^2), and what follows from it."""

    slider = 0.4

    def angles(self, theta):
        """(absolute angle of the rod, place of the slider)."""
        rod = -np.arcsin(CRANK * np.sin(theta) / COUPLER)
        return rod, CRANK * np.cos(theta) + COUPLER * np.cos(rod)

    def ratios(self, theta):
        """Rates of rod and slider for a crank that turns at 1 rad/s."""
        rod, _ = self.angles(theta)
        turn = -CRANK * np.cos(theta) / (COUPLER * np.cos(rod))
        return turn, -CRANK * np.sin(theta) - COUPLER * turn * np.sin(rod)

    def inertia(self, theta):
        """Reduced to the crank, kg m2."""
        rod, _ = self.angles(theta)
        turn, slide = self.ratios(theta)
        (a, own_a), (b, own_b) = bar(CRANK), bar(COUPLER)
        middle = CRANK * np.exp(1j * theta) + 0.5 * COUPLER * turn * np.exp(1j * rod)
        return own_a + 0.25 * a * CRANK**2 + b * abs(middle) ** 2 + own_b * turn**2 + self.slider * slide**2

    def height(self, theta):
        """Potential energy in gravity along -y, J; the slider keeps its height."""
        rod, _ = self.angles(theta)
        return 9.81 * (
            0.5 * bar(CRANK)[0] * CRANK * np.sin(theta)
            + bar(COUPLER)[0] * (CRANK * np.sin(theta) + 0.5 * COUPLER * np.sin(rod))
        )


def slope(function, at: float, step: float = 2e-4) -> float:
    """Derivative by five points."""
    near = (function(at + step) - function(at - step)) / (2.0 * step)
    far = (function(at + 2.0 * step) - function(at - 2.0 * step)) / (4.0 * step)
    return (4.0 * near - far) / 3.0


def crank_motion(mechanism, start: float, speed: float, torque: float, times: np.ndarray) -> np.ndarray:
    """(2, K) crank angles and rates under a constant torque: J a + J' w^2 / 2 + V' = torque."""

    def rate(_, y):
        theta, w = y
        bias = 0.5 * slope(mechanism.inertia, theta) * w * w + slope(mechanism.height, theta)
        return w, (torque - bias) / mechanism.inertia(theta)

    return solve_ivp(rate, (0.0, times[-1]), [start, speed], "DOP853", t_eval=times, rtol=1e-11, atol=1e-12).y


def sprung_crank_motion(mechanism, start, speed, torque, spring, rotor, times) -> np.ndarray:
    """(4, K) angles and rates of crank and motor, which a spring (stiffness, damping) joins."""
    stiffness, damping = spring

    def rate(_, y):
        theta, w, motor, turn = y
        twist = stiffness * (motor - theta) + damping * (turn - w)
        bias = 0.5 * slope(mechanism.inertia, theta) * w * w + slope(mechanism.height, theta)
        return w, (twist - bias) / mechanism.inertia(theta), turn, (torque - twist) / rotor

    begin = [start, speed, start, speed]
    return solve_ivp(rate, (0.0, times[-1]), begin, "DOP853", t_eval=times, rtol=1e-11, atol=1e-12).y
