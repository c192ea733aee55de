"""The march through time: temperatures of a door that burns, step by step.

    heat = Heat(door_model(load_scene("config/thesis_door.yaml")))
    status = heat.advance(60.0)

A step allocates no array of the leaf's size; one that fails leaves the last good state and a status that
says why.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..furnace.furnace import Furnace
from ..heat.conduction import Array, evaluate, field_of
from ..heat.linear import conjugate_gradients, factor_lines, krylov
from ..heat.method import METHODS, SDIRK2, Method
from ..heat.newton import newton_work
from ..heat.reactions import EQUILIBRIUM, progress_of
from ..heat.stage import CONVERGED, NOT_FINITE, ROUNDING, solve_stage
from ..model.door_model import DoorModel
from .status import State, Status

MOST_ITERATIONS = 60
SHORTEST_STEP = 1e-7
LONGEST_STEP = 600.0
GROWTH = 3.0
SEEN = 1e7 * ROUNDING
"""Share of the stored heat below which a step's balance says nothing: 4 microkelvin of a leaf at 500 °C."""
PLAIN = 1e-7
"""A balance as good as this needs no look at what rounding leaves of it."""


@dataclass
class HeatBalance:
    """Heat of the whole leaf since the start, J (of 1 m2 for a column, of 1 m for a strip).

    stored : of matter as it is; released : given by reactions, less what they took
    worst : the largest |stored - in - released| of any step, relative to what crossed the surfaces in it and
        what reactions gave and took
    last : that of the last step
    """

    stored: float = 0.0
    exposed: float = 0.0
    unexposed: float = 0.0
    lateral: float = 0.0
    released: float = 0.0
    last: float = 0.0
    worst: float = 0.0

    @property
    def relative(self) -> float:
        """|stored - in - released| over the whole run, relative to what crossed surfaces or was released."""
        crossed = abs(self.exposed) + abs(self.unexposed) + abs(self.lateral) + abs(self.released)
        entered = self.exposed + self.unexposed + self.lateral + self.released
        return abs(self.stored - entered) / crossed if crossed > 0.0 else 0.0


@dataclass
class Saved:
    """A state to go on from; see Heat.

    flow (N,) : W into each node; inflow (6,) : W through the surfaces; as the last step left them
    reacting : rates of the reactions, 1/s
    """

    time: float
    temperature: Array
    flow: Array
    inflow: Array
    rate: Array
    bend: Array
    last: float
    step: float
    started: bool
    balance: HeatBalance = field(default_factory=HeatBalance)
    degree: Array | None = None
    reacting: Array | None = None


class Heat:
    """Temperatures of a door model, marched through time.

    Attributes
    ----------
    time : s; temperature (N,) : °C, in the order of model.nodes
    rate (N,) : K/s, over the last step
    bend (N,) : K/s2, second divided difference over the last two; what comes is foreseen by both
    degree (P, N) : how far each reaction has gone at each node, 0 to 1; None or of size 0 where
        nothing reacts
    furnace : t -> °C; may be exchanged while running
    frozen : time, s, at which radiation and fluxes are looked up whatever the march's; None: its own
    status : why the march has stopped, if it has; balance : heat stored, in and out
    steps, rejected : steps taken, and thrown away for their error
    count (2,) : evaluations of the field, and linear iterations
    """

    def __init__(
        self, model: DoorModel, furnace: Furnace | None = None, method: Method | None = None
    ) -> None:
        self.model = model
        self.furnace: Furnace = model.furnace if furnace is None else furnace
        self.method = method or METHODS[model.scene.solver.method]
        _count, nz, ny, nx = model.grid.volume.shape
        n = nz * ny * nx
        self._nx, self._plane = nx, nx * ny
        self.frozen: float | None = None
        self.temperature = np.full(n, model.initial)
        self.rate = np.zeros(n)
        self.bend = np.zeros(n)
        self.count = np.zeros(2, dtype=np.int64)
        self._field = field_of(model.grid)
        self._krylov = krylov(n, self._plane, model.mesh.finite_elements)
        self._newton = newton_work(model.grid)
        self._correction = np.zeros(n)
        self._trial = np.zeros(n)
        self._base = np.zeros(n)
        self._heat = np.zeros(n)
        self._scratch = np.zeros(n)
        self._flows = np.zeros((3, n))
        self._inflows = np.zeros((3, 6))
        self._cancelling = model.radiation is not None or any(flux is not None for flux in model.flux)
        self._around = np.array([[model.ambient] * 3, [model.ambient] * 3, [0.0] * 3])
        self._heated = [surface for surface, is_hot in enumerate(model.gas) if is_hot]
        self._fluxes = [(surface, flux) for surface, flux in enumerate(model.flux) if flux is not None]
        self._ends = _table_ends(model)
        reactions = model.reactions
        self._progress = None if reactions is None else progress_of(reactions, n)
        self.degree = None if self._progress is None else self._progress.degree
        self._rates = np.zeros((3, 0 if reactions is None else len(reactions.kind), n))
        self.reset()

    def reset(self) -> None:
        """Back to the start of the test."""
        self.temperature[:] = self.model.initial
        if self.degree is not None:
            self.degree[:] = 0.0
        self._begin(0.0)

    def _begin(self, time: float) -> None:
        self.time = time
        self.stand_still()
        self.status = Status()
        self.balance = HeatBalance()
        self.steps = self.rejected = 0
        self.count[:] = 0
        self._step = 0.0
        self._started = False
        self._evaluate()

    def stand_still(self) -> None:
        """Foresee no change in the next step."""
        self.rate[:] = 0.0
        self.bend[:] = 0.0
        self._last = 0.0

    def save(self) -> Saved:
        """The state, to go on from later."""
        return Saved(
            self.time,
            self.temperature.copy(),
            self._flows[0].copy(),
            self._inflows[0].copy(),
            self.rate.copy(),
            self.bend.copy(),
            self._last,
            self._step,
            self._started,
            HeatBalance(**vars(self.balance)),
            None if self.degree is None else self.degree.copy(),
            None if self.degree is None else self._rates[0].copy(),
        )

    def restore(self, saved: Saved) -> None:
        """Go on from a saved state; the march from there is the one that was left, bit by bit.

        The furnace is not part of it: it stays as it is now, and counts from the next step on, as one that is
        exchanged while the march runs.
        """
        self.temperature[:] = saved.temperature
        if self.degree is not None:
            self.degree[:] = 0.0 if saved.degree is None else saved.degree
        self._begin(saved.time)
        # Not those of the furnace as it is now: what was measured since does not reach back.
        self._flows[0] = saved.flow
        self._inflows[0] = saved.inflow
        if saved.reacting is not None:
            self._rates[0] = saved.reacting
        self.rate[:] = saved.rate
        self.bend[:] = saved.bend
        self._last, self._step, self._started = saved.last, saved.step, saved.started
        self.balance = HeatBalance(**vars(saved.balance))

    def surroundings(self, time: float) -> Array:
        """Gas and radiation temperature, °C, and flux, W/m2: (3, 3), a column for each surface.

        One array, written anew at each call.
        """
        model, at = self.model, time if self.frozen is None else self.frozen
        gas = self.furnace(time)
        hot = gas if model.radiation is None else model.radiation(at)
        around = self._around
        for surface in self._heated:
            around[0, surface] = gas
            around[1, surface] = hot
        for surface, flux in self._fluxes:
            around[2, surface] = flux(at)
        return around

    def heat_flow(self) -> Array:
        """Heat inflow (3,) through exposed, unexposed and lateral surface now, W."""
        return self._inflows[0, :3] * self.model.mesh.parts

    def advance(self, to_time: float, each_step: Callable[[], None] | None = None) -> Status:
        """March to `to_time`, s, exactly, or to where the march has to stop.

        each_step : called after every step, for what must not wait until the end
        """
        fixed = self.model.scene.solver.step
        if self._step <= 0.0:
            self._step = fixed or self._first_step()
        halvings = 0
        while self.status.ok and to_time - self.time > 1e-9 * max(1.0, to_time):
            left = to_time - self.time
            step = min(self._step, (fixed or LONGEST_STEP) / 2**halvings)
            parts = np.ceil(left / step - 1e-6)
            if parts < 3 and not fixed:
                step = left / max(parts, 1.0)
            step = min(step, left)
            outcome, error = self.attempt(step)
            if outcome != CONVERGED:
                halvings += 1
                self._step = 0.5 * step
                if self._step < SHORTEST_STEP:
                    self.status = self._stopped(outcome)
                continue
            if fixed is not None:
                self._step = fixed
            else:
                tolerance = self.model.scene.solver.tolerance
                factor = 0.85 * (tolerance / max(error, 1e-12)) ** (1.0 / (self.method.order + 1))
                if error > tolerance and step > 1e3 * SHORTEST_STEP:
                    self.rejected += 1
                    self._step = step * max(0.2, min(factor, 0.9))
                    continue
                grown = step * min(GROWTH, factor)
                # A step cut short to end on time says nothing against a longer one.
                if grown > self._step or factor < 1.0 or step > 0.9 * self._step:
                    self._step = min(grown, LONGEST_STEP)
            self.accept(step)
            halvings = 0
            if each_step is not None:
                each_step()
        return self.status

    def _first_step(self) -> float:
        """A step in which nothing changes by more than a small part of the tolerance."""
        fastest = float(np.max(np.abs(self._flows[0]) / self._field.capacity))
        tolerance = self.model.scene.solver.tolerance
        return float(np.clip(0.1 * tolerance / max(fastest, 1e-12), 1e-3, 0.1))

    def burn_out(self) -> None:
        """Let all that has a rate have reacted, as it has when a state is steady."""
        if self._progress is not None and self.model.reactions is not None:
            self._progress.degree[self.model.reactions.kind != EQUILIBRIUM] = 1.0
            self._evaluate()

    def _evaluate(self) -> None:
        progress = self._progress
        if progress is not None:
            progress.base[:] = progress.degree
            progress.now[:] = progress.degree
        evaluate(
            self.temperature,
            self.surroundings(self.time),
            self.model.tables,
            self.model.grid,
            self.model.surface,
            self._field,
            0.0,
            self.model.cavities,
            self.model.reactions,
            progress,
        )
        if progress is not None:
            progress.degree[:] = progress.now
            self._rates[0] = progress.rate
        self._heat[:] = self._field.heat
        self._flows[0] = self._field.flow
        self._inflows[0] = self._field.surface_flow

    def attempt(self, step: float) -> tuple[int, float]:
        """Solve a step's stages into the trial state: how that came out, and its error, K."""
        method = self.method if self._started or self.method.error is None else SDIRK2
        trial, before = self._trial, 0.0
        trial[:] = self.temperature
        first = 0 if method.explicit else 1
        for i, place in enumerate(method.time):
            self._base[:] = self._heat
            for j, a in enumerate(method.couple[i]):
                np.multiply(self._flows[first + j], step * a, out=self._scratch)
                self._base += self._scratch
            self._foresee(before * step, place * step)
            if self._progress is not None:
                self._react(step, method, i)
            outcome = solve_stage(
                trial,
                self._base,
                method.diagonal * step,
                self.surroundings(self.time + place * step),
                self.model.tables,
                self.model.grid,
                self.model.surface,
                self._field,
                self._krylov,
                self._newton,
                self._correction,
                self.count,
                MOST_ITERATIONS,
                self.model.cavities,
                self.model.reactions,
                self._progress,
            )
            if outcome != CONVERGED:
                return outcome, np.inf
            self._flows[i + 1] = self._field.flow
            self._inflows[i + 1] = self._field.surface_flow
            if self._progress is not None:
                self._rates[i + 1] = self._progress.rate
            before = place
        self._weights = np.array(method.weight), first
        return CONVERGED, self._error(method, step)

    def _react(self, step: float, method: Method, stage: int) -> None:
        """What a stage of the reactions begins from, and degrees that are foreseen at its end."""
        progress, reactions = self._progress, self.model.reactions
        assert progress is not None and reactions is not None
        first, couple = (0 if method.explicit else 1), method.couple[stage]
        latest = first + len(couple) - 1 if couple else 0
        progress.base[:] = progress.degree
        for p in np.flatnonzero(reactions.kind != EQUILIBRIUM):
            for j, a in enumerate(couple):
                np.multiply(self._rates[first + j, p], step * a, out=self._scratch)
                progress.base[p] += self._scratch
        np.multiply(self._rates[latest], step * method.diagonal, out=progress.now)
        np.add(progress.now, progress.base, out=progress.now)
        np.minimum(progress.now, 1.0, out=progress.now)

    def _foresee(self, reached: float, after: float) -> None:
        """Move the trial from `reached` s after the state to `after`, by parabolas through what is known."""
        trial, last = self._trial, self._last
        if reached == 0.0:
            trial += after * self.rate
            trial += (after * (after + last)) * self.bend
        else:
            slope, rest = self._correction, after - reached
            np.subtract(trial, self.temperature, out=slope)
            slope /= reached
            trial += rest * slope
            if last > 0.0:
                slope -= self.rate
                slope *= after * rest / (reached + last)
                trial += slope

    def _error(self, method: Method, step: float) -> float:
        """Largest error of the trial step, K."""
        if self.model.scene.solver.step is not None or not self._started:
            return 0.0
        if method.error is None:
            off = self._scratch
            np.multiply(self.rate, step, out=off)
            off += self.temperature
            np.subtract(self._trial, off, out=off)
            return 0.5 * _largest(off)
        k, diagonal = self._krylov, method.diagonal * step
        np.dot(step * np.array(method.error), self._flows, out=k.r)
        reactions = self.model.reactions
        if reactions is not None:
            # The error of a degree is heat that is missing from the temperature.
            volume = self.model.grid.volume.reshape(len(self.model.materials), -1)
            for p in np.flatnonzero(reactions.kind != EQUILIBRIUM):
                np.dot(step * np.array(method.error), self._rates[:, p], out=self._scratch)
                self._scratch *= volume[reactions.material[p]]
                self._scratch *= reactions.taken[p]
                np.subtract(k.r, self._scratch, out=k.r)
        factor_lines(self._field, diagonal, self._nx, self._plane, k)
        self.count[1] += conjugate_gradients(self._correction, self._nx, self._plane, k, 0.1, 200)
        return _largest(self._correction)

    def accept(self, step: float) -> None:
        """Make the attempted state the present one, and keep account of its heat."""
        weights, first = self._weights
        used = slice(first, first + len(weights))
        inflow = step * weights @ self._inflows[used, :3] * self.model.mesh.parts
        change = self._scratch
        np.subtract(self._field.heat, self._heat, out=change)
        stored = float(np.sum(change)) * self.model.mesh.parts
        given, taken = (
            (0.0, 0.0) if self._progress is None else self._progress.exchanged * self.model.mesh.parts
        )
        balance = self.balance
        balance.stored += stored + given - taken
        balance.released += given - taken
        balance.exposed += inflow[0]
        balance.unexposed += inflow[1]
        balance.lateral += inflow[2]
        crossed = float(np.abs(inflow).sum())
        if self._cancelling:
            crossed = step * float((weights @ self._inflows[used, 3:]).sum()) * self.model.mesh.parts
        crossed += given + taken
        off = abs(stored - float(inflow.sum()))
        if off > PLAIN * crossed:
            # Of less than this, rounding of the stored heat is a millionth and more: a leaf at rest.
            size = float(np.sum(np.abs(self._field.heat, out=change)))
            size += float(self._field.capacity @ np.abs(self._trial, out=change))
            crossed = max(crossed, SEEN * size * self.model.mesh.parts)
        balance.last = 0.0 if off == 0.0 else off / crossed
        balance.worst = max(balance.worst, balance.last)
        self.bend[:] = self.rate
        np.subtract(self._trial, self.temperature, out=self.rate)
        self.rate /= step
        if self._last > 0.0:
            np.subtract(self.rate, self.bend, out=self.bend)
            self.bend /= step + self._last
        else:
            self.bend[:] = 0.0
        self._last = step
        self.temperature[:] = self._trial
        self._heat[:] = self._field.heat
        last = len(weights) - 1 + first
        if self._progress is not None:
            self._progress.degree[:] = self._progress.now
            self._rates[0] = self._rates[last]
        self._flows[0] = self._flows[last]
        self._inflows[0] = self._inflows[last]
        self.time += step
        self.steps += 1
        self._started = True
        self._check_tables()

    def _check_tables(self) -> None:
        for name, what, end, nodes in self._ends:
            there = np.take(self.temperature, nodes, out=self._scratch[: len(nodes)], mode="clip")
            hottest = int(nodes[np.argmax(there)])
            if self.temperature[hottest] > end:
                x, y, z = self.model.nodes[hottest]
                self.status = Status(
                    State.BEYOND_TABLE,
                    f"stopped at {self.time:.1f} s: {name} is {self.temperature[hottest]:.1f} °C at"
                    f" x {x:.3f} y {y:.3f} z {z:.4f} m, beyond the end of its {what} table at"
                    f" {end:g} °C; give values to there, or beyond: hold or extend",
                )
                return

    def _stopped(self, outcome: int) -> Status:
        if outcome == NOT_FINITE:
            return Status(
                State.NOT_FINITE,
                f"stopped at {self.time:.3f} s: a temperature is not finite; look at the"
                " furnace's temperature and the materials' tables",
            )
        return Status(
            State.NOT_CONVERGED,
            f"stopped at {self.time:.3f} s: no step above {SHORTEST_STEP:g} s converges; look for"
            " a jump in a material's table",
        )


def _largest(values: Array) -> float:
    """The largest magnitude."""
    return max(float(np.max(values)), -float(np.min(values)))


def _table_ends(model: DoorModel) -> list[tuple[str, str, float, NDArray[np.int64]]]:
    """Material, property, its table's end (°C) and the nodes it concerns."""
    ends = []
    for m, material in enumerate(model.materials):
        nodes = np.flatnonzero(model.mesh.volume[m].ravel() > 0.0)
        for what, curve in (
            ("conductivity", material.conductivity),
            ("specific_heat", material.specific_heat),
        ):
            if np.isfinite(curve.refuse_above) and len(nodes):
                ends.append((material.name, what, curve.refuse_above, nodes))
    return ends
