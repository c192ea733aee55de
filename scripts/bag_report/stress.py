"""Stress along the links, from elastic states and the sections of the scene.

At the ends of each element its strains follow from its nodes (elements/beam.py): extension with, under
the effect `centrifugal`, the mean of half the squared slope; the curvatures of its cubics; its twist. With
the formulation `co_moving`, whose turns may be large, all is taken about each element's chord. Of a
section's points the worst is taken: normal stress where both bendings and the axial force add up, and with
it, by von Mises, the largest shear of torsion and of the transverse forces, which in a rectangle lie
elsewhere: so the stress is never less than what the section bears. A transverse force is what changes the
bending moment along an element; its shear is 3/2 of its mean, that of a rectangle (Timoshenko, Strength of
Materials I, 26).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flexsim_node import Scene
from flexsim_node.elements.element import stiffening
from flexsim_node.elements.section import section
from flexsim_node.model.erls import beam_axes
from flexsim_node.scene.schema import Beam, Link

from ..bag import Bag, BagError
from ..bag.messages import Gathered, Messages, Thinner
from .motion import SECOND, Layout
from .reading import STAMP

# Of a rectangle's shear stress under a transverse force, over its mean.
LARGEST_SHEAR = 1.5
# More elastic states are thinned, and the report says so.
MOST = 400_000
AT_ONCE = 512
Array = NDArray[np.float64]
FIELDS = ["displacement", "rigid_position", *STAMP]
Bend = tuple[Array, Array, Array]
Ends = tuple[Array, Array, Bend, Bend]


@dataclass(frozen=True)
class LinkStress:
    """The largest stress that a link bore.

    Attributes
    ----------
    peak : Pa, von Mises; at, s, simulated; where, m from the link's start
    parts : Pa, normal stress of the axial force and of bending, shear of torsion and of transverse forces,
        there and then
    place : (P,) m from the link's start; most : (P,) Pa, the largest there over time
    assumed : the section was given by constants, so a rectangle with the same second moments is taken
    """

    link: str
    peak: float
    at: float
    where: float
    parts: tuple[float, float, float, float]
    place: Array
    most: Array
    assumed: bool


def outer(beam: Beam) -> tuple[float, float, bool]:
    """Return half the width and half the depth of a section, m, and whether they are assumed."""
    if beam.width is not None and beam.depth is not None:
        return beam.width / 2.0, beam.depth / 2.0, False
    s = section(beam)
    # A rectangle a x b with a b^3 / 12 = iy, b a^3 / 12 = iz.
    width = (144.0 * s.iz**3 / s.iy) ** 0.125
    depth = (144.0 * s.iy**3 / s.iz) ** 0.125
    return width / 2.0, depth / 2.0, True


def largest_twist_shear(width: float, depth: float) -> float:
    """Return the largest shear stress of a twisted rectangle over shear modulus times twist, m.

    Timoshenko and Goodier, Theory of Elasticity, 109.
    """
    a, b = max(width, depth), min(width, depth)
    n = np.arange(1, 40, 2)
    return float(b * (1.0 - 8.0 / np.pi**2 * np.sum(1.0 / (n**2 * np.cosh(0.5 * n * np.pi * a / b)))))


class LinkStrain:
    """The stress of one link's sections, from its nodes' displacements.

    Parameters
    ----------
    link : Link, with a beam
    nodes : ndarray (n,), places of its nodes among the robot's
    length : ndarray (n - 1,), m, of its elements
    scene : Scene, whose effects and formulation count
    """

    def __init__(self, link: Link, nodes: NDArray[np.int64], length: Array, scene: Scene) -> None:
        assert link.beam is not None
        shear, self.stiffening = scene.effects.shear is True, stiffening(scene)
        self.co_moving = scene.co_moving
        beam = link.beam
        self.link, self.nodes, self.length = link, nodes, length
        self.axes, _ = beam_axes(link)
        self.modulus = beam.youngs_modulus
        self.shear_modulus = beam.youngs_modulus / (2.0 * (1.0 + beam.poissons_ratio))
        s = section(beam)
        self.stiffness = beam.youngs_modulus * np.array([s.iz, s.iy])
        self.area = s.area
        self.half_width, self.half_depth, self.assumed = outer(beam)
        self.twist_arm = largest_twist_shear(2.0 * self.half_width, 2.0 * self.half_depth)
        kind = 12.0 * beam.youngs_modulus / (self.shear_modulus * length**2)
        self.give_z = kind * s.iz / s.shear_area_y if shear else np.zeros_like(length)
        self.give_y = kind * s.iy / s.shear_area_z if shear else np.zeros_like(length)
        start = np.concatenate([[0.0], np.cumsum(length)])
        self.place = np.stack([start[:-1], start[1:]], axis=1).ravel()

    def __call__(self, displacement: Array) -> tuple[Array, Array, Array, Array]:
        """Return normal stress of axial force and of bending, shear of torsion and of forces, (K, P), Pa.

        displacement (K, N, 6) in the link's frame; P places, the two ends of each element.
        """
        own = displacement[:, self.nodes]
        moved, turned = own[:, :, :3] @ self.axes, own[:, :, 3:] @ self.axes
        strain = self._along_chords if self.co_moving else self._along_link
        stretch, twist, (rise_y, z1, z2), (rise_z, y1, y2) = strain(moved, turned)
        kappa_z, slope_z = self._bending(rise_y, z1, z2, self.give_z)
        kappa_y, slope_y = self._bending(rise_z, y1, y2, self.give_y)
        if self.stiffening:
            stretch = stretch + 0.5 * (slope_z + slope_y)
        axial = self.modulus * np.abs(np.repeat(stretch, 2, axis=1))
        bending = self.modulus * (self.half_width * np.abs(kappa_z) + self.half_depth * np.abs(kappa_y))
        torsion = self.shear_modulus * self.twist_arm * np.abs(np.repeat(twist, 2, axis=1))
        moments = self.stiffness[:, None, None] * np.stack([kappa_z, kappa_y])
        forces = (moments[:, :, 1::2] - moments[:, :, ::2]) / self.length
        transverse = LARGEST_SHEAR / self.area * np.linalg.norm(forces, axis=0)
        return axial, bending, torsion, np.repeat(transverse, 2, axis=1)

    def _along_link(self, moved: Array, turned: Array) -> Ends:
        """Return stretch, twist and both bendings' (rise, slopes) (K, E) from small displacements."""
        step = np.diff(moved, axis=1)
        twist = np.diff(turned[:, :, 0], axis=1) / self.length
        # Bending in x-y: slope is the turn about z; in x-z: minus the turn about y.
        first, second = turned[:, :-1], turned[:, 1:]
        return (
            step[:, :, 0] / self.length,
            twist,
            (step[:, :, 1], first[:, :, 2], second[:, :, 2]),
            (step[:, :, 2], -first[:, :, 1], -second[:, :, 1]),
        )

    def _along_chords(self, moved: Array, turned: Array) -> Ends:
        """The same about each element's chord, where turns may be large and are rotation vectors."""
        count = moved.shape[:2]
        section_axes = Rotation.from_rotvec(turned.reshape(-1, 3)).as_matrix().reshape(*count, 3, 3)
        chord = np.diff(moved, axis=1)
        chord[:, :, 0] += self.length
        long = np.linalg.norm(chord, axis=2)
        first, second = section_axes[:, :-1], section_axes[:, 1:]
        seen = [np.einsum("keij,kei->kej", axes, chord) for axes in (first, second)]
        # The chord as each end's section sees it; the section turns the other way from the chord.
        z1, z2 = (-np.arctan2(c[:, :, 1], c[:, :, 0]) for c in seen)
        y1, y2 = (-np.arctan2(c[:, :, 2], c[:, :, 0]) for c in seen)
        between = np.einsum("keij,keim->kejm", first, second).reshape(-1, 3, 3)
        twist = Rotation.from_matrix(between).as_rotvec()[:, 0].reshape(long.shape) / self.length
        flat = np.zeros_like(long)
        return long / self.length - 1.0, twist, (flat, z1, z2), (flat, y1, y2)

    def _bending(self, rise: Array, t1: Array, t2: Array, give: Array) -> tuple[Array, Array]:
        """Return curvatures at both ends of each element (K, 2 E) and means of the squared slope (K, E)."""
        length = self.length
        stiff = 1.0 / (1.0 + give)  # with shear, only this part of the difference bends the element
        off = rise / length - 0.5 * (t1 + t2)
        mean, end = (t2 - t1) / length, 6.0 * stiff * off / length
        kappa = np.stack([mean + end, mean - end], axis=2).reshape(len(rise), -1)
        # The cubic's slopes at its ends, times the length.
        give_way = (1.0 - stiff) * length * off
        h1, h2 = length * t1 + give_way, length * t2 + give_way
        square = 36.0 * rise**2 - 6.0 * rise * (h1 + h2) + 4.0 * (h1**2 + h2**2) - 2.0 * h1 * h2
        return kappa, square / (30.0 * length**2)


def of_links(scene: Scene, layout: Layout, rigid_position: Array) -> list[LinkStrain]:
    """Return what gives the stress of each flexible link of a scene; rigid_position (N, 3) of any state.

    Raises
    ------
    ValueError
        The scene is not that of the layout.
    """
    if [link.name for link in scene.links] != list(layout.link_names):
        raise ValueError(
            f"the scene has the links {', '.join(link.name for link in scene.links)}; the bag has "
            f"{', '.join(layout.link_names)}"
        )
    found = []
    for n, link in enumerate(scene.links):
        nodes = np.flatnonzero(layout.node_link == n)
        if link.beam is None or not link.flexible or len(nodes) < 2:
            continue
        length = np.linalg.norm(np.diff(rigid_position[nodes], axis=0), axis=1)
        if abs(float(length.sum()) - link.length) > 1e-6 * link.length + 1e-9:
            raise ValueError(
                f"{link.name} is {link.length:g} m long in the scene, {float(length.sum()):g} m in the bag"
            )
        found.append(LinkStrain(link, nodes, length, scene))
    return found


class Stresses:
    """The largest stresses of each flexible link over a bag, taken up as it is read.

    Parameters
    ----------
    bag : Bag
    topic : str, of its elastic states
    scene : Scene
    layout : Layout
    """

    def __init__(self, bag: Bag, topic: str, scene: Scene, layout: Layout) -> None:
        count = bag.topic(topic).count
        self.period = bag.duration / MOST if count > MOST else 0.0
        self.topic = topic
        self._path, self._scene, self._layout = bag.path, scene, layout
        self._decoder = bag.decoder(topic)
        self._keep = Thinner(self.period)
        # Many at once: a chunk alone holds too few for NumPy to be quick.
        self._waiting = Gathered(AT_ONCE)
        self._links: list[LinkStrain] | None = None
        self._best: list[tuple[float, float, float, tuple[float, float, float, float]]] = []
        self._most: list[Array] = []
        self._problem: ValueError | BagError | None = None

    def add(self, messages: Messages) -> None:
        """Take up elastic states."""
        ready = self._waiting.add(self._keep(messages))
        if ready is not None:
            self._look(ready)

    def found(self) -> list[LinkStress]:
        """Return what each link bore.

        Raises
        ------
        ValueError
            The scene is not that of the bag.
        BagError
            The elastic states do not fit their layout.
        """
        ready = self._waiting.all()
        if ready is not None:
            self._look(ready)
        if self._problem is not None:
            raise self._problem
        return [
            LinkStress(link.link.name, *self._best[n], link.place, self._most[n], link.assumed)
            for n, link in enumerate(self._links or [])
        ]

    def _look(self, messages: Messages) -> None:
        if self._problem is None:
            try:
                self._take(self._decoder.columns(messages, FIELDS))
            except (ValueError, BagError) as problem:
                self._problem = problem

    def _take(self, columns: dict[str, NDArray[Any]]) -> None:
        displacement = np.asarray(columns["displacement"], dtype=float)
        if displacement.shape[1] != 6 * self._layout.nodes:
            raise BagError(f"{self._path}: {self.topic} does not fit its layout")
        displacement = displacement.reshape(len(displacement), -1, 6)
        if self._links is None:
            first = columns["rigid_position"][0].reshape(-1, 3)
            self._links = of_links(self._scene, self._layout, first)
            self._best = [(-1.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0))] * len(self._links)
            self._most = [np.zeros(len(link.place)) for link in self._links]
        time = columns[STAMP[0]] + columns[STAMP[1]] / SECOND
        for n, link in enumerate(self._links):
            axial, bending, torsion, transverse = link(displacement)
            mises = np.sqrt((axial + bending) ** 2 + 3.0 * (torsion + transverse) ** 2)
            k, p = np.unravel_index(np.nanargmax(mises), mises.shape)
            self._most[n] = np.maximum(self._most[n], np.nanmax(mises, axis=0))
            if mises[k, p] > self._best[n][0]:
                parts = (
                    float(axial[k, p]), float(bending[k, p]), float(torsion[k, p]), float(transverse[k, p])
                )  # fmt: skip
                self._best[n] = (float(mises[k, p]), float(time[k]), float(link.place[p]), parts)
