"""How far the formulations are apart on a scene's own motion: the error of the model itself."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ValidationError

from .effects import Drive, Trial, everything_open_on
from .schema import Scene


@dataclass(frozen=True)
class Apart:
    """Distance of a scene's tips between its formulation and another.

    Attributes
    ----------
    own, other : formulations
    distance : m, the largest at one time; unsure : m, what twice the elements change of it
    refused : why it isn't known, or ""
    """

    own: str
    other: str
    distance: float
    unsure: float
    refused: str = ""


def in_formulation(scene: Scene, name: str) -> Scene:
    """The scene in another formulation.

    Raises
    ------
    ValueError
        where that one does not take the scene
    """
    keys = scene.model_dump()
    keys["formulation"] = name
    if name == "co_moving" and scene.erls.zeroed in ("chord", "root", "auto"):
        keys["erls"] = {"zeroed": "root"}
    try:
        return Scene.model_validate(keys)
    except ValidationError as problem:
        said = problem.errors()[0]["msg"].removeprefix("Value error, ")
        raise ValueError(f"{name} does not take the scene: {said}") from None


def with_twice_the_elements(scene: Scene) -> Scene:
    """The scene with every flexible link's mesh halved."""
    links = tuple(
        link.model_copy(update={"beam": link.beam.model_copy(update={"elements": 2 * link.beam.elements})})
        if link.beam is not None and link.flexible
        else link
        for link in scene.links
    )
    return scene.model_copy(update={"links": links})


def formulations_apart(scene: Scene, drive: Drive = None, duration: float | None = None) -> Apart:
    """Measure how far the other formulation's tips are from the scene's on its own motion.

    What lies between the meshes is no matter of the formulation: it is told as `unsure`.

    Raises
    ------
    ArithmeticError
        where the scene itself does not run to its end
    """
    own = everything_open_on(scene)
    other = "co_moving" if own.formulation == "erls" else "erls"
    try:
        changed = in_formulation(own, other)
    except ValueError as problem:
        return Apart(own.formulation, other, float("nan"), float("nan"), str(problem))
    fine = Trial(with_twice_the_elements(own), drive, duration)
    distance, trouble = fine.distance(with_twice_the_elements(changed))
    coarse, more = Trial(own, drive, duration).distance(changed)
    if trouble or more:
        return Apart(own.formulation, other, float("nan"), float("nan"), f"{other}: {trouble or more}")
    return Apart(own.formulation, other, distance, abs(distance - coarse))
