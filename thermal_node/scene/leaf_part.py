"""What a scene says of the leaf: its layers, cavities and contacts, and the rim around them.

Numbers are SI, temperatures °C.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from flexsim_core.quantities import Misplaced, Part
from pydantic import Discriminator, Field, Tag, model_validator

from .quantities import ContactResistance, Fraction, GreyEmissivity, Size, Thickness

THIN = 3e-3
"""m; a layer up to this thick gets one brick where the scene gives no count."""

CAVITY = "cavity"
"""What a cavity is called in lists of layers by their materials."""


class Layer(Part):
    """One layer of the leaf, from the exposed face on.

    contact_resistance : m2 K/W, between this layer and the one before
    """

    material: str
    thickness: Thickness
    contact_resistance: ContactResistance | None = None

    @property
    def is_cavity(self) -> bool:
        """Whether this is a cavity."""
        return False

    def bricks(self, thick: int) -> int:
        """Bricks through the layer where the scene gives no count; `thick` : of a thick one."""
        return 1 if self.thickness <= THIN else thick


class CavityLayer(Part):
    """A closed cavity between two layers, filled with air.

    cavity : m, its width; emissivity : of its two faces, that towards the fire first
    convection : still (air at rest), en_673, elsherbiny (a tall cavity)
    """

    cavity: Thickness
    emissivity: tuple[GreyEmissivity, GreyEmissivity]
    convection: Literal["still", "en_673", "elsherbiny"] = "en_673"

    @property
    def thickness(self) -> float:
        """m."""
        return self.cavity

    @property
    def material(self) -> str:
        """For lists of layers by name."""
        return CAVITY

    @property
    def contact_resistance(self) -> None:
        """A cavity's own resistance is that of its air and its radiation."""
        return

    @property
    def is_cavity(self) -> bool:
        """Whether this is a cavity."""
        return True

    def bricks(self, thick: int) -> int:
        """One: heat crosses a cavity from face to face."""
        return 1


def _kind(value: Any) -> str:
    if isinstance(value, CavityLayer) or (isinstance(value, dict) and "cavity" in value):
        return "[cavity]"
    return "[layer]"


AnyLayer = Annotated[
    Annotated[Layer, Tag("[layer]")] | Annotated[CavityLayer, Tag("[cavity]")], Discriminator(_kind)
]


class Rim(Part):
    """The channel that closes the leaf's edge and bridges its faces.

    contact : 0 to 1, the share of the full channel's conduction through the thickness
    """

    material: str = "steel"
    thickness: Thickness
    contact: Fraction = 1.0


class Leaf(Part):
    """The door leaf."""

    height: Size
    width: Size
    layers: Annotated[tuple[AnyLayer, ...], Field(min_length=1, max_length=20)]
    rim: Rim | None = None

    @property
    def thickness(self) -> float:
        """m."""
        return sum(layer.thickness for layer in self.layers)

    @model_validator(mode="after")
    def _possible(self) -> Leaf:
        last = len(self.layers) - 1
        for i, layer in enumerate(self.layers):
            if layer.is_cavity:
                if i in (0, last):
                    raise Misplaced(
                        ("layers", i), "is a cavity at the leaf's face; give layers on both sides of it"
                    )
                if self.layers[i + 1].is_cavity:
                    raise Misplaced(
                        ("layers", i + 1), "is a cavity beside a cavity; give one, or a sheet between"
                    )
            elif layer.contact_resistance is not None and (i == 0 or self.layers[i - 1].is_cavity):
                before = "no layer" if i == 0 else "a cavity"
                raise Misplaced(
                    ("layers", i, "contact_resistance"),
                    f"has {before} before it to touch; give it to a layer that lies on another",
                )
        return self
