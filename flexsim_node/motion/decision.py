"""What was decided of a scene's open keys (`auto`): formulation, effects, and what for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scene.schema import Scene
from .envelope import Envelope


@dataclass(frozen=True)
class Change:
    """What switching one effect does to a scene's run.

    Attributes
    ----------
    name : of the effect, or `flexible: LINK`
    on : whether the scene has it; the other way round is what is measured
    change : m, the largest distance of a tip from itself at one time; infinite where the other run fails
    relative : change over the tip's own largest distance from where it starts
    trouble : why the other way can't run, or ""
    """

    name: str
    on: bool
    change: float
    relative: float
    trouble: str = ""


def millimetres(length: float) -> str:
    """A length in words."""
    return f"{1e3 * length:.3g} mm" if np.isfinite(length) else "without bound"


@dataclass(frozen=True)
class Apart:
    """Distance of a scene's tips between its formulation and another.

    Attributes
    ----------
    own, other : formulations
    distance : m, the largest at one time, with twice the elements and half the step (or more)
    unsure : m, what these change of it
    refused : why it isn't known, or ""
    """

    own: str
    other: str
    distance: float
    unsure: float
    refused: str = ""

    @property
    def most(self) -> float:
        """m that the formulations are apart at most, as far as it is told; infinite where it isn't."""
        return float("inf") if self.refused else self.distance + self.unsure


@dataclass(frozen=True)
class Chosen:
    """The formulation that `auto` has taken, and why.

    Attributes
    ----------
    scene : in that formulation; open effects are still open
    apart : erls from co_moving, at most over the envelope; None where nothing was measured
    why : a sentence
    envelope : what the decision holds for, where erls was taken by a measurement
    at_rest : whether the scene does not move, which decides nothing
    """

    scene: Scene
    why: str
    apart: Apart | None = None
    envelope: Envelope | None = None
    at_rest: bool = False

    @property
    def off(self) -> float:
        """m of the tolerance that the formulation takes up, as far as it is known."""
        measured = self.apart is not None and self.scene.formulation == "erls"
        return self.apart.most if self.apart and measured else 0.0

    def sentence(self) -> str:
        """What was taken, and why."""
        return f"formulation: {self.scene.formulation}; {self.why}"


@dataclass(frozen=True)
class Decision:
    """What of that which a scene leaves open (`auto`) is simulated, and why.

    Attributes
    ----------
    scene : formulation and every effect decided
    tolerance : m at the tip
    changes : of every open effect alone, the smallest first
    left_out : those that are off; together : m that they change together, at most over the envelope
    envelope : what the decision holds for; None where nothing that could matter is left out
    at_rest : whether the scene does not move, which decides nothing
    chosen : the formulation, where that was open
    """

    scene: Scene
    tolerance: float
    changes: tuple[Change, ...]
    left_out: tuple[str, ...]
    together: float
    envelope: Envelope | None = None
    at_rest: bool = False
    chosen: Chosen | None = None

    def sentences(self) -> list[str]:
        """A line for the formulation and for each open effect, and one for all that are left out."""
        lines = [] if self.chosen is None else [self.chosen.sentence()]
        lines += [
            f"{c.name}: {'off' if c.name in self.left_out else 'on'},"
            f" without it the tip is {millimetres(c.change)} off" + (f" ({c.trouble})" if c.trouble else "")
            for c in self.changes
        ]
        return lines + ([self.effects_said()] if self.changes else [])

    def effects_said(self) -> str:
        """Which effects are left out."""
        if self.at_rest:
            return (
                "left out: nothing; the tips move by less than the tolerance, which decides nothing: give the"
                " scene a torque or a start that moves them"
            )
        what = ", ".join(self.left_out) or "nothing"
        said = f"left out: {what}; together {millimetres(self.together)} of {millimetres(self.tolerance)}"
        off = 0.0 if self.chosen is None else self.chosen.off
        return said + (f", beside the formulation's {millimetres(off)}" if off > 0.0 else "")

    def summary(self) -> str:
        """The whole in one line."""
        formulation = [] if self.chosen is None else [self.chosen.sentence()]
        return "; ".join([*formulation, *([self.effects_said()] if self.changes else [])])
