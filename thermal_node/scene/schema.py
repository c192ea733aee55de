"""What a fire door's scene may say, part by part (parts.py), and what its parts say of each other.

Loading and the wording of refusals are in load.py.
"""

from __future__ import annotations

import difflib
from typing import Any, Literal

from flexsim_core.quantities import Misplaced, Part
from pydantic import Field, model_validator

from .criteria_part import CriteriaPart, SealsPart
from .deformation_part import DeformationPart
from .furnace_part import FurnacePart, LateralPart, SurfacePart
from .leaf_part import Leaf
from .library import LIBRARY
from .names import check_names
from .parts import (
    MaterialPart,
    MeshPart,
    ProbesPart,
    Property,
    SolverPart,
)
from .quantities import (
    Ambient,
    Temperature,
)
from .size import too_large
from .supports import mechanism, off_the_leaf


class Scene(Part):
    """A fire door's scene, as design.md's section on scene files lays it down."""

    model: Literal["fire_door"]
    name: str = "door"
    source: str = ""
    leaf: Leaf
    materials: dict[str, MaterialPart] = Field(default_factory=dict)
    furnace: FurnacePart = FurnacePart()
    exposed: SurfacePart = SurfacePart()
    unexposed: SurfacePart = SurfacePart()
    lateral: LateralPart = LateralPart()
    ambient: Ambient = 20.0
    initial: Temperature | None = None
    mesh: MeshPart = MeshPart()
    solver: SolverPart = SolverPart()
    probes: ProbesPart = ProbesPart()
    criteria: CriteriaPart = CriteriaPart()
    seals: SealsPart = SealsPart()
    deformation: DeformationPart = DeformationPart()

    @property
    def start(self) -> float:
        """Temperature of the leaf before the fire, °C."""
        return self.ambient if self.initial is None else self.initial

    @model_validator(mode="before")
    @classmethod
    def _from_library(cls, given: Any) -> Any:
        """Layers may name a material of the library that the scene says nothing of."""
        if not isinstance(given, dict) or not isinstance(given.get("leaf"), dict):
            return given
        leaf, materials = given["leaf"], given.get("materials")
        layers = leaf.get("layers")
        parts = [*(layers if isinstance(layers, (list, tuple)) else ()), leaf.get("rim")]
        named = [part.get("material") for part in parts if isinstance(part, dict)]
        said = materials if isinstance(materials, dict) else {}
        taken = {
            name: {"library": name}
            for name in named
            if isinstance(name, str) and name in LIBRARY and name not in said
        }
        return {**given, "materials": {**said, **taken}} if taken else given

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        check_names(self.leaf, self.materials, self.probes, self.criteria, self.deformation)
        self._materials_known()
        self._mesh_fits()
        self._tables_reach()
        self._radiation_is_seen()
        large = too_large(self.leaf, self.solver, self.mesh, self.deformation)
        if large is not None:
            raise Misplaced(*large)
        return self

    def _materials_known(self) -> None:
        used: list[tuple[tuple[str | int, ...], str]] = [
            (("leaf", "layers", i, "material"), layer.material)
            for i, layer in enumerate(self.leaf.layers)
            if not layer.is_cavity
        ]
        if self.leaf.rim is not None:
            used.append((("leaf", "rim", "material"), self.leaf.rim.material))
        known = sorted({*self.materials, "steel"})
        for path, name in used:
            if name not in known:
                near = difflib.get_close_matches(name, [*known, *LIBRARY], 1)
                right = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known)}"
                right += f"; the library has {', '.join(LIBRARY)}"
                raise Misplaced(path, f"is {name!r}, which materials does not hold; {right}")
        for name, material in self.materials.items():
            if name == "steel" or material.standard is not None:
                continue
            for key in ("density", "specific_heat", "conductivity"):
                if getattr(material, key) is None:
                    raise Misplaced(("materials", name), f"lacks {key}; give it")

    def _mesh_fits(self) -> None:
        layers = len(self.leaf.layers)
        for section in ("mesh", "deformation"):
            given = getattr(self, section).layers
            if given is not None and len(given) != layers:
                raise Misplaced((section, "layers"), f"has {len(given)} entries; give one a layer: {layers}")
        for i, layer in enumerate(self.leaf.layers):
            given = self.mesh.layers
            if layer.is_cavity and given is not None and given[i] != 1:
                raise Misplaced(
                    ("mesh", "layers", i), f"is {given[i]} of a cavity, which heat crosses at once; give 1"
                )
        rim = self.leaf.rim
        if rim is not None:
            if 2.0 * rim.thickness >= min(self.leaf.width, self.leaf.height):
                raise Misplaced(
                    ("leaf", "rim", "thickness"),
                    f"is {rim.thickness:g}; give less than half of the leaf's width and height",
                )
            least = 2 if self.mesh.symmetry == "quarter" else 3
            if self.solver.dimension != "column" and min(self.mesh.in_plane) < least:
                raise Misplaced(
                    ("mesh", "in_plane"), f"leaves no brick beside the rim; give at least {least}"
                )
        depth = self.lateral.depth
        if depth is not None and depth > self.leaf.thickness * (1.0 + 1e-9):
            raise Misplaced(
                ("lateral", "depth"), f"is {depth:g}; give at most the leaf's {self.leaf.thickness:g} m"
            )
        off = off_the_leaf(self.leaf, self.deformation)
        if off is not None:
            raise Misplaced(*off)
        cavity = any(layer.is_cavity for layer in self.leaf.layers)
        if cavity and self.deformation.model != "none":
            raise Misplaced(
                ("deformation", "model"),
                f"is {self.deformation.model} of a leaf with a cavity, whose skins bend apart, which is not"
                " computed; give none",
            )
        free = mechanism(self.leaf, self.deformation) if self.deformation.model != "none" else ""
        if free:
            raise Misplaced(("deformation",), free)
        for i, name in enumerate(self.criteria.points):
            point = self.probes.points.get(name)
            if point is None or (point.z is not None and point.z < self.leaf.thickness - 1e-9):
                raise Misplaced(
                    ("criteria", "points", i),
                    f"is {name!r}, no point of probes.points on the unexposed face; give one of them"
                    f" ({', '.join(self.probes.points) or 'there is none'})",
                )
        half = (0.5 * self.leaf.width, 0.5 * self.leaf.height, self.leaf.thickness)
        for name, point in self.probes.points.items():
            for key, limit in zip(("x", "y", "z"), half, strict=True):
                value = getattr(point, key)
                if value is not None and abs(value) > limit + 1e-9:
                    raise Misplaced(
                        ("probes", "points", name, key),
                        f"is {value:g}, off the leaf; give at most {limit:g} m",
                    )

    def _radiation_is_seen(self) -> None:
        """Of the furnace's radiation something depends, and a flux enters what is not held."""
        steady = self.solver.model == "steady"
        if self.exposed.flux is not None and steady and self.exposed.held is None:
            raise Misplaced(
                ("exposed", "flux"), "enters a face that steady holds; give exposed: held: false as well"
            )
        if self.furnace.radiation is None:
            return
        for face, exposed in ((self.exposed, True), (self.unexposed, False), (self.lateral, False)):
            held = face.held or (steady and exposed and face.held is None)
            in_furnace = (face.gas or ("furnace" if exposed else "ambient")) == "furnace"
            emissivity = (0.7 if exposed else 0.0) if face.emissivity is None else face.emissivity
            if in_furnace and not held and emissivity > 0.0:
                return
        raise Misplaced(
            ("furnace", "radiation"),
            "meets no surface: none in the furnace's gas is free and has an emissivity; give one,"
            " or leave it out",
        )

    def _tables_reach(self) -> None:
        """No temperature that the scene is sure to reach lies above a table's end."""
        reached = [(self.start, "the door starts at"), (self.ambient, "the ambient is at")]
        furnace = self.furnace.temperature
        if isinstance(furnace, float):
            reached.append((furnace, "the furnace is at"))
        elif furnace:
            reached.append((max(furnace), f"the {self.furnace.curve} furnace goes to"))
        names = {layer.material for layer in self.leaf.layers}
        for name, material in self.materials.items():
            if name not in names:
                continue
            for key in ("conductivity", "specific_heat"):
                table: Property | None = getattr(material, key)
                if table is None or table.temperature is None or table.beyond != "refuse":
                    continue
                end = table.temperature[-1]
                for temperature, what in reached:
                    if temperature > end:
                        raise Misplaced(
                            ("materials", name, key, "temperature"),
                            f"ends at {end:g} °C but {what} {temperature:g} °C; give values to"
                            f" {temperature:g} °C, or beyond: hold or extend",
                        )
