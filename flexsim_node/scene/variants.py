"""Scenes made of a scene: an effect or the formulation switched, more elements, shorter steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import ValidationError

from .schema import HELD_BY_FRAMES, Effects, Scene


def opened(scene: Scene) -> dict[str, Any]:
    """The keys of a scene that `auto` decides."""
    return {key: getattr(scene, key) for key in ("formulation", "erls", "effects")}


def starting(scene: Scene, key: str, values: np.ndarray) -> Scene:
    """The scene with its joints at these positions, or at these velocities (m,), at the start."""
    initial = scene.initial.model_copy(update={key: tuple(values.tolist())})
    return scene.model_copy(update={"initial": initial})


def effect_names() -> tuple[str, ...]:
    """Names of all effects."""
    return tuple(Effects.model_fields)


def with_effect(scene: Scene, name: str, on: bool) -> Scene:
    """The scene with one effect, or one link's flexibility (`flexible: LINK`), switched."""
    kind, _, link = name.partition(": ")
    if link:
        links = tuple(k.model_copy(update={"flexible": on}) if k.name == link else k for k in scene.links)
        return scene.model_copy(update={"links": links})
    return scene.model_copy(update={"effects": scene.effects.model_copy(update={kind: on})})


def is_on(scene: Scene, name: str) -> bool:
    """Whether an effect, or a link's flexibility, is on; what is open counts as on."""
    kind, _, link = name.partition(": ")
    if link:
        return next(k.flexible for k in scene.links if k.name == link)
    return getattr(scene.effects, kind) is not False


def everything_open_on(scene: Scene) -> Scene:
    """The scene with its open effects on: what the others are compared with."""
    for name in scene.effects.undecided:
        scene = with_effect(scene, name, True)
    return scene


def in_formulation(scene: Scene, name: str) -> Scene:
    """The scene in another formulation; open effects that co-moving frames hold are then on.

    Raises
    ------
    ValueError
        where that one does not take the scene
    """
    keys = scene.model_dump()
    keys["formulation"] = name
    if name == "co_moving":
        if scene.erls.zeroed == "chord":
            keys["erls"] = {"zeroed": "auto"}  # the chord again, should it come back
        for effect in HELD_BY_FRAMES:
            if keys["effects"][effect] == "auto":
                keys["effects"][effect] = True
    try:
        return Scene.model_validate(keys)
    except ValidationError as problem:
        error = problem.errors()[0]
        cause = error.get("ctx", {}).get("error")
        key = ".".join(str(k) for k in getattr(cause, "path", ()))
        said = error["msg"].removeprefix("Value error, ")
        raise ValueError(f"{name} does not take the scene: {key} {said}") from None


def nothing_left_out(scene: Scene) -> Scene:
    """The scene with its open effects on, in co-moving frames where it leaves the formulation open.

    Where those don't take the scene it stays with the ERLS.
    """
    on = everything_open_on(scene)
    if on.formulation != "auto":
        return on
    try:
        return in_formulation(on, "co_moving")
    except ValueError:
        return in_formulation(on, "erls")


def more_elements(scene: Scene, times: int) -> Scene:
    """The scene with `times` the elements in every flexible link."""
    links = tuple(
        link.model_copy(
            update={"beam": link.beam.model_copy(update={"elements": times * link.beam.elements})}
        )
        if link.beam is not None and link.flexible
        else link
        for link in scene.links
    )
    return scene.model_copy(update={"links": links})


def finer(scene: Scene, times: int) -> Scene:
    """The scene with `times` the elements, and steps so many times shorter.

    Explicit steps go with the squared length of an element; adaptive methods choose theirs.
    """
    parts = {"runge_kutta_4": times**2, "radau": 1, "dop853": 1}.get(scene.solver.method, times)
    solver = scene.solver.model_copy(update={"step": scene.solver.step / parts})
    return more_elements(scene, times).model_copy(update={"solver": solver})


def elements(scene: Scene) -> int:
    """The largest number of elements of a flexible link; 0 where none bends."""
    return max((k.beam.elements for k in scene.links if k.beam is not None and k.flexible), default=0)
