"""What the validity watch saw, in numbers and words, against the scene's limits."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..compiled.kernel import entry
from ..elements import planar_beam, spatial_beam
from ..equations.co_moving import plane, space
from ..equations.dynamics.residual import residual
from ..equations.kinematics.nodal_motion import place
from ..equations.reduced import plane as planar_reduced_beam
from ..equations.reduced import space as spatial_reduced_beam
from ..model.chain import BUCKLING, COUNT, DISPLACEMENT, FIRST, FIRST_ELEMENT, KIND, PRISMATIC, TIP, workspace
from ..model.erls import erls_condition
from ..model.model import Model
from ..model.reduced.layout import MODES
from .load_stiffness import LoadStiffness

LOOK_PERIOD = 0.1  # s between looks at what the steps themselves do not watch
# the watch's rows, then what is looked at now and then
NAMES = (
    "elastic_rotation",
    "spin_ratio",
    "correction",
    "axial_load",
    "erls_condition",
    "mass_condition",
    "load_stiffness",
)
UNITS = ("rad", "", "m or rad", "", "", "", "")
WORDS = (
    "the elastic rotation",
    "the spin over the first bending frequency",
    "the last correction of a step's iteration",
    "the axial load over the buckling load",
    "the condition of J_0",
    "the condition of the mass matrix",
    "what loads take from the stiffness, as a share of it,",
)
ADVICE = (
    "rotations of earlier links reach later ones linearly: give formulation: co_moving, stiffer links, or a"
    " smaller step",
    "without the effect centrifugal nothing stiffens a spinning link: switch it on",
    "the step follows this motion only just: give a smaller step",
    "the link may buckle: give a stiffer section; without the effect centrifugal it can't, so switch that on",
    "the zeroed dofs hardly define the rigid links here: give other ones, or root",
    "a joint has hardly any inertia beyond it here: give it a rotor_inertia",
    "at 1 it buckles: formulation: erls holds to first order of this share, co_moving to any; give that, or"
    " stiffer links",
)
LEFT_OUT = (
    "the effect centrifugal is off, so that this is left out of the motion: switch it on, together with axial"
)


@dataclass(frozen=True)
class Finding:
    """One figure of the watch, the largest so far, and its limits (inf where there is none)."""

    name: str
    value: float
    link: str
    warn: float
    stop: float
    co_moving: bool = False  # the formulation, which decides what would help
    left_out: bool = False  # whether the equations leave out what loads do to the stiffness

    @property
    def passed(self) -> str:
        """`stop`, `warn`, or nothing."""
        return "stop" if self.value > self.stop else "warn" if self.value > self.warn else ""

    def sentence(self) -> str:
        """What was passed, by how much, and what to do."""
        k = NAMES.index(self.name)
        where = f"{self.link}: " if self.link else ""
        limit = self.stop if self.passed == "stop" else self.warn
        unit = f" {UNITS[k]}" if UNITS[k] else ""
        key = f"validity.{self.name}.{self.passed or 'warn'}"
        advice = ADVICE[k]
        if k == 0 and self.co_moving:
            advice = "it is meant small inside an element: give the link more elements"
        if self.name == "load_stiffness" and self.left_out:
            advice = LEFT_OUT
        elif self.name == "load_stiffness" and self.co_moving:
            advice = "at 1 it buckles: give stiffer links"
        return f"{where}{WORDS[k]} reaches {self.value:.3g}{unit}, beyond {key} = {limit:g}; {advice}"


class Seen(NamedTuple):
    """The largest of each figure so far (7,), and the links where it was, -1 for none."""

    values: tuple[float, ...]
    links: tuple[int, ...]


class ValidityWatch:
    """Gathers what every step's watch wrote into `seen` (2, 3), and looks at the rest now and then.

    loads : buffers of the loads on the links' ends, `external` and `loaded` of a Workspace
    """

    def __init__(self, model: Model, seen: np.ndarray, **loads: np.ndarray) -> None:
        self.model, self.seen = model, seen
        self.sampled = np.zeros(4)
        self.pushed = -1  # the link with the largest axial load
        self._work = work = workspace(model.chain)
        zero, torque = np.zeros(model.unknowns), np.zeros(model.joints)
        self._place = entry(place, model.chain, work, zero)
        self._residual = entry(residual, model.chain, work, zero, zero, zero, torque, zero)
        self._stiffness = LoadStiffness(model, **loads)

    def begin(self) -> None:
        """Begin as a new watch does, so that the same run is always judged alike."""
        self.clear()
        self._stiffness.begin()

    def clear(self) -> None:
        """Forget what was seen."""
        self.seen[:] = 0.0
        self.sampled[:] = 0.0

    def look(self, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> bool:
        """Take axial load, both conditions and the loads' share of the stiffness; False beyond a stop.

        x, v, a : (n,) unknowns, rates, accelerations
        """
        for _ in self.glances(x, v, a):
            pass
        return not self.beyond

    def glances(self, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> Generator[None]:
        """The same in parts, for callers with deadlines; x, v and a must stay as they are."""
        model = self.model
        self._place(model.chain, self._work, x)
        loads = axial_loads(model, self._work)
        yield
        own = erls_condition(model.chain, model.zeroed, x[: model.joints]) if model.swings else 1.0
        yield
        inertia = yield from mass_condition(model, self._work, x, self._residual)
        taken = yield from self._stiffness.glances(x, v, a)
        if loads.max() > self.sampled[0]:
            self.pushed = int(np.argmax(loads))
        np.maximum(self.sampled, (loads.max(), own, inertia, taken), out=self.sampled)

    @property
    def beyond(self) -> bool:
        """Whether anything that was looked at is beyond its stop."""
        stops = self.model.limits[:, 1]
        return bool((self.seen[0] > stops[:3]).any() or (self.sampled > stops[3:]).any())

    def so_far(self) -> Seen:
        """What was seen, to be put into words later."""
        values = (*self.seen[0].tolist(), *self.sampled.tolist())
        return Seen(values, (*self.seen[1].astype(int).tolist(), self.pushed, -1, -1, -1))

    def findings(self, seen: Seen | None = None) -> tuple[Finding, ...]:
        """Every figure with its limits; of what was seen so far."""
        names = [link.name for link in self.model.scene.links]
        values, links = seen or self.so_far()
        found = []
        for k, name in enumerate(NAMES):
            link = names[links[k]] if values[k] > 0.0 and links[k] >= 0 else ""
            warn, stop = map(float, self.model.limits[k])
            moving = bool(self.model.chain.co_moving)
            found.append(Finding(name, values[k], link, warn, stop, moving, self._stiffness.left_out))
        return tuple(found)

    def sentences(self, passed: str) -> tuple[str, ...]:
        """One for each figure beyond its `warn` (but not `stop`), or beyond its `stop`."""
        return tuple(f.sentence() for f in self.findings() if f.passed == passed)


def axial_loads(model: Model, work) -> np.ndarray:
    """(L,) largest compression in each link over its buckling load, where `place` has put the nodes."""
    chain = model.chain
    d = work.node[DISPLACEMENT]
    tension = planar_beam.axial_force if model.planar else spatial_beam.axial_force
    rows = plane.element_rows if model.planar else space.element_rows
    reduced_tension = (planar_reduced_beam if model.planar else spatial_reduced_beam).axial_force
    found = np.zeros(len(chain.link))
    for n, row in enumerate(chain.link):
        if chain.joint[n, BUCKLING] > 0.0 and chain.reduced[n, MODES] >= 0:
            whole = chain.element[row[FIRST_ELEMENT]]
            given = (chain.reduced[n], chain.modal, work.modal, whole, d, row[FIRST])
            found[n] = max(0.0, -reduced_tension(*given) / chain.joint[n, BUCKLING])
        elif chain.joint[n, BUCKLING] > 0.0:
            for k in range(row[COUNT]):
                i, nodes = row[FIRST] + k + 1, d
                if chain.co_moving:
                    rows(d[i], work.pair[0])
                    i, nodes = 1, work.pair[0]
                push = -tension(chain.element[row[FIRST_ELEMENT] + k], nodes, i)
                found[n] = max(found[n], push / chain.joint[n, BUCKLING])
    return found


def mass_condition(
    model: Model, work, x: np.ndarray, residual: Callable[..., Any]
) -> Generator[None, None, float]:
    """Condition of the joints' inertia (m, m) at the unknowns x (n,), bit by bit; `residual` as compiled.

    Where joints turn and slide, angles count as lengths at the robot's reach.
    """
    chain, m = model.chain, model.joints
    zero, base, column = np.zeros((3, x.size))
    torque, inertia = np.zeros(m), np.zeros((m, m))
    residual(chain, work, x, zero, zero, torque, base)
    unit = np.zeros(x.size)
    for k in range(m):
        unit[k] = 1.0
        residual(chain, work, x, zero, unit, torque, column)
        unit[k] = 0.0
        inertia[k] = base[:m] - column[:m]
        yield
    slides = chain.link[model.joint_links, KIND] == PRISMATIC
    scale = np.where(slides, 1.0, 1.0 / (np.sum(np.abs(chain.joint[:, TIP])) or 1.0))
    values = np.linalg.svd(inertia * scale * scale[:, None], compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > 0.0 else np.inf
