"""A fire door ready to be solved: everything that does not change while it burns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..furnace.furnace import FILM_COEFFICIENT, Furnace, furnace_of
from ..furnace.tabled import Radiation, Table, flux_of, radiation_of
from ..heat.conduction import Array, Grid, Surface, Tables
from ..heat.convection import Cavities
from ..heat.reactions import Reactions
from ..mesh.door import door_mesh
from ..mesh.exchange import Exchange
from ..mesh.gaps import gaps_of
from ..mesh.leaf import LeafMesh
from ..scene.furnace_part import SurfacePart
from ..scene.parts import MaterialPart, Property
from ..scene.schema import Scene
from ..scene.standards import STANDARDS
from .gap import NO_CAVITIES, cavities_of, gap_material
from .materials import STEEL_DENSITY, Curve, Material, constant, steel, table
from .reacting import NO_REACTIONS, reactions_of
from .rebate import free_edge

HELD = 1e9
"""W/(m2 K) of a surface that is held at its gas' temperature."""
BINS = 4096
QUICK = 0.2
"""s; see _compact."""
PEAK = 2.0
"""A specific heat that varies by more has a peak; see _consistent."""


@dataclass(frozen=True)
class DoorModel:
    """Built once from a scene by `door_model`; never changes.

    gas : for the exposed, unexposed and lateral surface, whether it is the furnace's
    radiation : °C over time, where the furnace does not radiate at its gas' temperature
    flux : for the same surfaces, W/m2 over time that enters besides
    cavities, reactions : of whose air moves, and what materials give or take once; None where neither is
    """

    scene: Scene
    mesh: LeafMesh
    materials: tuple[Material, ...]
    tables: Tables
    grid: Grid
    surface: Surface
    gas: tuple[bool, bool, bool]
    furnace: Furnace
    radiation: Radiation | None
    flux: tuple[Table | None, Table | None, Table | None]
    cavities: Cavities | None
    reactions: Reactions | None
    ambient: float
    initial: float

    @property
    def nodes(self) -> Array:
        """(N, 3), m: x across the width, y up, both from the centre, z from the exposed face."""
        return self.mesh.nodes


def door_model(scene: Scene) -> DoorModel:
    """Build the model of a scene. Raises SceneError where a furnace's log can't be used."""
    mesh = door_mesh(scene)
    gaps = gaps_of(scene.leaf)
    materials = tuple(material_of(name, scene) for name in mesh.material_names)
    materials += tuple(gap_material(gap) for gap in gaps)
    nz, ny, nx = mesh.shape
    area = np.zeros((3, nz, ny, nx))
    area[0, 0] = mesh.exposed_area
    area[1, -1] += mesh.unexposed_area
    depth = scene.lateral.depth
    area[2] = mesh.lateral_area if depth is None else free_edge(mesh, depth)
    steady = scene.solver.model == "steady"
    surfaces = (scene.exposed, scene.unexposed, scene.lateral)
    default_film = (FILM_COEFFICIENT.get(scene.furnace.curve, 25.0), 10.0, 0.0)
    default_emissivity = (0.7, 0.0, 0.0)
    film, emissivity = np.zeros(3), np.zeros(3)
    for i, part in enumerate(surfaces):
        film[i], emissivity[i] = _meets(part, default_film[i], default_emissivity[i])
        if part.held or (steady and i == 0 and part.held is None):
            film[i], emissivity[i] = HELD, 0.0
    # Kernels are compiled for a door without either, or for one that may have both.
    cavities = cavities_of(scene.leaf, len(mesh.material_names))
    reactions = reactions_of(materials, mesh)
    if (cavities is None) != (reactions is None):
        cavities, reactions = cavities or NO_CAVITIES, reactions or NO_REACTIONS
    return DoorModel(
        scene=scene,
        mesh=mesh,
        materials=materials,
        tables=_tables(materials),
        grid=Grid(
            mesh.volume,
            mesh.conduction,
            (_consistent if mesh.finite_elements else _compact)(mesh, materials),
        ),
        surface=Surface(area, film, emissivity),
        gas=(
            scene.exposed.gas != "ambient",
            scene.unexposed.gas == "furnace",
            scene.lateral.gas == "furnace",
        ),
        furnace=furnace_of(scene.furnace, scene.source, STANDARDS[scene.criteria.standards[0]].curve),
        radiation=radiation_of(scene.furnace.radiation),
        cavities=cavities,
        reactions=reactions,
        flux=(flux_of(scene.exposed.flux), flux_of(scene.unexposed.flux), flux_of(scene.lateral.flux)),
        ambient=scene.ambient,
        initial=scene.start,
    )


def _compact(mesh: LeafMesh, materials: tuple[Material, ...]) -> Exchange:
    """Volume, m3, whose heat neighbours through the thickness exchange.

    With a twelfth of a brick at its far end the sum of its heat is the compact one, of fourth
    order. But in a brick that heat crosses slowly it would make one end colder while the other
    warms; so it is used in full only where a brick settles within QUICK.
    """
    share = np.zeros_like(mesh.volume)
    thickness = np.diff(mesh.z)
    for m, material in enumerate(materials[: len(mesh.material_names)]):
        heat = material.density * float(material.specific_heat.values.max())
        slowest = float(material.conductivity.values.min())
        settles = thickness**2 * heat / (12.0 * slowest)
        part = QUICK / np.maximum(settles, QUICK) / 12.0
        share[m, :-1] = mesh.conduction.z[m, :-1] * (part * thickness**2)[:, None, None]
    return mesh.mass._replace(z=share)


def _consistent(mesh: LeafMesh, materials: tuple[Material, ...]) -> Exchange:
    """The consistent capacity's exchange, m3, of materials without a peak of specific heat or reactions.

    A node at a peak would hardly take part in what its neighbours exchange, however they share it: capacity
    is lumped there, as for a change of phase.
    """
    heats = [material.specific_heat.values for material in materials]
    even = np.array(
        [float(c.max() <= PEAK * c.min() and not m.reactions) for c, m in zip(heats, materials, strict=True)]
    )
    return Exchange(*(even[:, None, None, None] * part for part in mesh.mass))


def _meets(part: SurfacePart, film: float, emissivity: float) -> tuple[float, float]:
    return (
        film if part.film_coefficient is None else part.film_coefficient,
        emissivity if part.emissivity is None else part.emissivity,
    )


def material_of(name: str, scene: Scene) -> Material:
    """The scene's material of that name; steel's by Eurocode 3 where it says nothing else."""
    part = scene.materials.get(name, MaterialPart())
    eurocode = name == "steel" or part.standard is not None
    density = part.density or STEEL_DENSITY
    base = steel(density=density)

    def curve(given: Property | None, default: Curve, otherwise: Curve) -> Curve:
        if given is None:
            return default if eurocode else otherwise
        if given.rule is not None:
            return default
        if given.constant is not None:
            return constant(given.constant)
        assert given.temperature is not None and given.value is not None
        return table(given.temperature, given.value, given.beyond)

    elongation = part.elongation
    if elongation is not None and elongation.constant is not None:
        # A constant is a coefficient, 1/K: elongation from 20 °C.
        slope = elongation.constant
        stretch = table([-280.0, 3000.0], [-300.0 * slope, 2980.0 * slope], "hold")
    else:
        stretch = curve(elongation, base.elongation, constant(0.0))
    poisson = part.poissons_ratio
    return Material(
        name=name,
        density=density,
        specific_heat=curve(part.specific_heat, base.specific_heat, constant(1000.0)),
        conductivity=curve(part.conductivity, base.conductivity, constant(1.0)),
        youngs_modulus=curve(part.youngs_modulus, base.youngs_modulus, constant(0.0)),
        poissons_ratio=poisson if poisson is not None else (0.3 if eurocode else 0.0),
        elongation=stretch,
        reactions=part.all_reactions(),
        oxygen_diffusivity=part.oxygen_diffusivity or 0.0,
    )


def _tables(materials: tuple[Material, ...]) -> Tables:
    start, knots, bins, per_kelvin = [0], [], [], []
    for m in materials:
        t = np.union1d(m.specific_heat.knots, m.conductivity.knots)
        rate = BINS / (t[-1] - t[0])
        left = t[0] + np.arange(BINS + 1) / rate
        below = np.clip(np.searchsorted(t, left - 1e-9, side="right") - 1, 0, len(t) - 2)
        bins.append(start[-1] + below)
        per_kelvin.append(rate)
        knots.append(t)
        start.append(start[-1] + len(t))
    pairs = list(zip(materials, knots, strict=True))
    return Tables(
        start=np.array(start),
        knot=np.concatenate(knots),
        enthalpy=np.concatenate([m.enthalpy(t) for m, t in pairs]),
        capacity=np.concatenate([m.remaining * m.specific_heat(t) for m, t in pairs]),
        theta=np.concatenate([m.conductivity.integrated(t) for m, t in pairs]),
        conductivity=np.concatenate([m.conductivity(t) for m, t in pairs]),
        bin=np.array(bins),
        bins_per_kelvin=np.array(per_kelvin),
    )
