"""The grid of a robot's study: integrators, steps and meshes of either formulation, reduction, effects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, get_args

from flexsim_node import Scene, load_scene

from .point import Point

REAL_TIME = ("rosenbrock_w", "generalized_alpha")
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)
EXPLICIT_STEPS = (5e-5, 2e-5, 1e-5, 5e-6, 2e-6)
TOLERANCES = (1e-3, 1e-5, 1e-7)
ELEMENTS = (1, 2, 4, 8)
OTHER_ELEMENTS, OTHER_STEPS = (2, 4, 8), STEPS[1:5]
"""Of the formulation that the scene has not."""
MODES = {4: (2, 4), 8: (2, 4, 8)}
"""Modes a link that a mesh of so many elements is reduced to."""
REDUCED_STEPS = STEPS[1:4]
VARIANT_STEPS = (2e-3, 1e-3, 5e-4)
EFFECT_STEP = 1e-3
FORMULATIONS = tuple(n for n in get_args(Scene.model_fields["formulation"].annotation) if n != "auto")


class RobotGrid:
    """What a robot scene can be simulated with.

    document, given : the scene as it was read and its overrides; scene : both, checked
    period : s between samples, which adaptive methods step by
    vary : further axes, a scene key to its values
    quick : the smallest grid that still shows something
    others : overrides of the formulations that the scene has not, where these are more than their names
    named : whether points of the scene's own formulation say which it is
    """

    def __init__(
        self,
        document: Mapping[str, Any],
        given: Mapping[str, Any],
        scene: Scene,
        period: float,
        vary: Mapping[str, list[Any]],
        quick: bool,
        others: Mapping[str, Mapping[str, Any]] | None = None,
        named: bool = False,
    ) -> None:
        self.others, self.own = dict(others or {}), f"{scene.formulation}, " if named else ""
        self.document, self.given, self.scene = document, dict(given), scene
        self.period, self.vary, self.quick = period, vary, quick
        self.steps = STEPS[1:4] if quick else STEPS
        self.elements = ELEMENTS[:2] if quick else ELEMENTS

    @cached_property
    def flexible(self) -> list[str]:
        """What an override calls the flexible links."""
        return [self.written[k.name] for k in self.scene.links if k.beam is not None and k.flexible]

    @cached_property
    def written(self) -> dict[str, str]:
        """What an override calls each link of the file: its number, unless another is named so.

        The scene's own numbers are others where points became links of it.
        """
        names = [str(link["name"]) for link in self.document["links"]]
        return {name: name if str(k) in names else str(k) for k, name in enumerate(names)}

    @cached_property
    def _reduced(self) -> bool:
        return any(self.scene.modes_of(link) is not None for link in self.scene.links)

    def meshed(self, elements: int, modes: int | None = None) -> dict[str, Any]:
        """Overrides for so many elements a link: all of them, or reduced to `modes` modes."""
        found: dict[str, Any] = {f"links.{k}.beam.elements": elements for k in self.flexible}
        if modes is not None or self._reduced:
            own = [self.written[k.name] for k in self.scene.links if k.reduction is not None]
            found["reduction"] = None if modes is None else {"modes": modes}
            found |= {f"links.{k}.reduction": None for k in own}
        return found

    def other_formulations(self) -> dict[str, dict[str, Any]]:
        """The formulations that the scene has not, with their overrides."""
        root = {} if self.scene.erls.zeroed in ("root", "auto") else {"erls.zeroed": "root"}
        return {
            name: {"formulation": name, **(root if name == "co_moving" else {}), **self.others.get(name, {})}
            for name in FORMULATIONS
            if name != self.scene.formulation
        }

    def refusal(self, overrides: Mapping[str, Any]) -> str:
        """Why the scene can't be so, or ""."""
        try:
            load_scene(self.document, {**self.given, **overrides})
        except ValueError as problem:
            return str(problem)
        return ""

    def points(self) -> list[Point]:
        """Own formulation, explicit and adaptive methods, the others, reductions, variants, effects."""
        found = list(self._own())
        if not self.quick:
            found += self._checks()
        for name, overrides in self.other_formulations().items():
            found += self._other(name, overrides)
        found += self._reductions()
        for said, overrides in self._variants():
            for step in self.steps[:1] if self.quick else VARIANT_STEPS:
                found.append(Point(said, step, {"solver.step": step, **overrides}))
        for said, overrides in self._effects():
            found.append(Point(said, EFFECT_STEP, {"solver.step": EFFECT_STEP, **overrides}, effect=True))
        return found

    def _own(self) -> Iterator[Point]:
        for n in self.elements if self.flexible else (0,):
            mesh = self.meshed(n) if n else {}
            for method in REAL_TIME:
                for step in self.steps:
                    changed = {"solver.method": method, "solver.step": step, **mesh}
                    yield Point(self.own + method + mesh_said(n), step, changed)

    def _checks(self) -> Iterator[Point]:
        for step in EXPLICIT_STEPS:
            changed = {"solver.method": "runge_kutta_4", "solver.step": step}
            yield Point(f"{self.own}runge_kutta_4", step, changed)
        for method in ("radau", "dop853"):
            for tolerance in TOLERANCES:
                changed = {
                    "solver.method": method,
                    "solver.step": self.period,
                    "solver.relative_tolerance": tolerance,
                    "solver.absolute_tolerance": 1e-2 * tolerance,
                }
                yield Point(self.own + method, tolerance, changed)

    def _other(self, name: str, overrides: dict[str, Any]) -> Iterator[Point]:
        """The other formulation with both methods; once where the scene refuses it, to say why."""
        if self.refusal(overrides) or not self.flexible:
            yield Point(name, EFFECT_STEP, {"solver.step": EFFECT_STEP, **overrides})
            return
        for n in self.elements[-1:] if self.quick else OTHER_ELEMENTS:
            for method in REAL_TIME[:1] if self.quick else REAL_TIME:
                for step in self.steps[:2] if self.quick else OTHER_STEPS:
                    changed = {"solver.method": method, "solver.step": step, **overrides, **self.meshed(n)}
                    yield Point(f"{name}, {method}{mesh_said(n)}", step, changed)

    def _reductions(self) -> Iterator[Point]:
        if not self.flexible:
            return
        # Where the formulation is open reduced links are those of the ERLS, which alone takes them.
        erls = self.other_formulations().get("erls", {}) if self.own else {}
        said = "erls, " if erls else self.own
        if self.refusal({**erls, **self.meshed(4, 2)}):
            changed = {"solver.step": EFFECT_STEP, **erls, **self.meshed(4, 2)}
            yield Point("reduced links", EFFECT_STEP, changed)
            return
        for n, counts in {4: (2,)}.items() if self.quick else MODES.items():
            for modes in counts:
                for step in self.steps[:1] if self.quick else REDUCED_STEPS:
                    solver = {"solver.method": REAL_TIME[0], "solver.step": step}
                    changed = {**solver, **erls, **self.meshed(n, modes)}
                    yield Point(f"{said}{REAL_TIME[0]}{mesh_said(n)}, {modes} modes", step, changed)

    def _variants(self) -> list[tuple[str, dict[str, Any]]]:
        """Zeroed dofs and what --vary asks for, one at a time."""
        scene = self.scene
        found: list[tuple[str, dict[str, Any]]] = []
        if scene.formulation == "erls":
            zeroed = [s for s in ("root", "chord") if s != scene.erls.zeroed]
            found += [(f"zeroed: {s}", {"erls.zeroed": s}) for s in zeroed]
        for key, values in self.vary.items():
            found += [(f"{key}={value}", {key: value}) for value in values]
        return found[:1] if self.quick else found

    def _effects(self) -> list[tuple[str, dict[str, Any]]]:
        """Each effect the other way round."""
        found: list[tuple[str, dict[str, Any]]] = []
        for name, value in self.scene.effects:
            if isinstance(value, bool):
                found.append((f"{name} {'off' if value else 'on'}", {f"effects.{name}": not value}))
        return found[:3] if self.quick else found


def mesh_said(elements: int) -> str:
    """For example ", 8 elements a link"."""
    return f", {elements} element{'s' * (elements != 1)} a link" if elements else ""
