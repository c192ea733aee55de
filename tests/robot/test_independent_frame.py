"""The frame program that loaded robots are held against: closed forms of loaded beams."""

import numpy as np
import pytest
from independent_frame import Frame, extrapolated, torsion_constant
from scipy.optimize import brentq

LENGTH, YOUNG, POISSON, DENSITY = 0.6, 7.0e10, 0.3, 2700.0
SHEAR = YOUNG / 2.0 / (1.0 + POISSON)


class Strip:
    """A cantilever along x, `width` along y and `depth` along z."""

    def __init__(self, width, depth):
        self.area, self.torsion = width * depth, SHEAR * torsion_constant(width, depth)
        self.bend_y, self.bend_z = YOUNG * width * depth**3 / 12, YOUNG * depth * width**3 / 12
        self.polar = (width * depth**3 + depth * width**3) / 12
        self.line = DENSITY * self.area

    def frame(self, count, line=1.0, rotary=0.0, start=0.0, bifilar=False, **keys):
        stiffness = [YOUNG * self.area, 0, 0, self.torsion, self.bend_y, self.bend_z]
        inertia = [rotary * DENSITY * b / YOUNG for b in (self.bend_y, self.bend_z)]
        frame = Frame(**keys)
        radius = self.polar / self.area * float(bifilar)
        start = np.array([start, 0.0, 0.0])
        self.tip = frame.beam(
            0, start, np.eye(3), LENGTH, count, stiffness, (line * self.line, *inertia), radius
        )
        return frame


def test_cantilever_frequencies():
    """Bending both ways, at rest: 1.8751^2, 4.6941^2 sqrt(E I / m) / L^2."""
    strip = Strip(0.02, 0.01)
    found = extrapolated(lambda n: strip.frame(n, rotary=1e-6).solved().frequencies(4), 12)
    unit = np.sqrt(np.array([strip.bend_y, strip.bend_z]) / strip.line) / LENGTH**2 / 2 / np.pi
    right = np.sort(np.outer(unit, np.array([1.8751041, 4.6940911]) ** 2).ravel())
    assert np.allclose(found, right, rtol=5e-4)


def test_euler_column():
    """The first frequency of a column with a mass on top falls to nothing at pi^2 E I / (4 L^2)."""
    strip = Strip(0.02, 0.002)
    critical = np.pi**2 * strip.bend_y / 4 / LENGTH**2

    def squared(part, count):
        frame = strip.frame(count, line=1e-6)
        frame.bodies.append((strip.tip, np.zeros(3), 1.0, 1e-9 * np.eye(3)))
        frame.loads.append((strip.tip, np.zeros(3), [-part * critical, 0, 0], np.zeros(3)))
        return frame.solved().frequencies(1)[0] ** 2

    # k = P c / (tan(c L) - c L), c^2 = P / E I: stiffness of a clamped column's loaded end
    for part in (0.5, 0.9):
        c = np.sqrt(part * critical / strip.bend_y)
        right = part * critical * c / (np.tan(c * LENGTH) - c * LENGTH) / (2 * np.pi) ** 2
        assert extrapolated(lambda n, p=part: squared(p, n), 8) == pytest.approx(right, rel=2e-3)
    with pytest.raises(ArithmeticError, match="not stable"):
        squared(1.02, 16)


def test_lateral_buckling():
    """A deep cantilever with a force on its end buckles sideways at 4.0126 sqrt(E I G J) / L^2."""
    strip = Strip(0.04, 0.0005)  # so deep that its sag before buckling does not count
    critical = 4.0126 * np.sqrt(strip.bend_y * strip.torsion) / LENGTH**2

    def lowest(part, count):
        frame = strip.frame(count)
        frame.loads.append((strip.tip, np.zeros(3), [0, -part * critical, 0], np.zeros(3)))
        return np.linalg.eigvalsh(frame.solved().balance()[1])[0]

    found = extrapolated(lambda n: np.array(brentq(lambda p: lowest(p, n), 0.9, 1.1, xtol=1e-5)), 12)
    assert found == pytest.approx(1.0, abs=1e-3)


def test_torque_on_a_bent_shaft():
    """A torque with a fixed direction draws a cantilever's sag under a side force out of its plane.

    With w = y + i z and its slope p: E I p' = F (L - s) - i T p, clamped.
    """
    strip = Strip(0.01, 0.01)
    torque, side = 0.4 * np.pi * strip.bend_y / LENGTH, 1e-3

    def tip(count):
        frame = strip.frame(count)
        frame.loads.append((strip.tip, np.zeros(3), [0, side, 0], [torque, 0, 0]))
        return frame.solved().place[-1, 1:]

    k = torque / strip.bend_y
    s = np.linspace(0.0, LENGTH, 20001)
    p = np.exp(-1j * k * s) * np.concatenate(
        [
            [0],
            np.cumsum(
                np.diff(s)
                * 0.5
                * (lambda g: g[1:] + g[:-1])(side / strip.bend_y * (LENGTH - s) * np.exp(1j * k * s))
            ),
        ]
    )
    w = np.sum(np.diff(s) * 0.5 * (p[1:] + p[:-1]))
    found = extrapolated(tip, 12)
    assert found[0] == pytest.approx(w.real, rel=1e-3)
    assert abs(found[1]) == pytest.approx(abs(w.imag), rel=1e-3)
