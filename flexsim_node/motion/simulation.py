"""A robot in motion: one state, advanced step by step.  Offline runs and the real-time loop share it."""

from __future__ import annotations

from collections.abc import Callable, Generator

import numpy as np

from ..compiled.by_reference import by_reference
from ..compiled.kernel import entry
from ..equations.dynamics.acceleration import LOOP_OPEN, NOT_VALID, OK, REASONS, drive_joints
from ..equations.dynamics.end_acceleration import Jumps, Rates, end_accelerations
from ..equations.dynamics.energy import energy
from ..integrators import METHODS
from ..model.chain import Robot, Workspace, workspace
from ..model.dofs import is_planar
from ..model.model import Model, build_model, check_zeroed
from ..scene.load import Scene, SceneError
from ..scene.variants import opened
from ..sensors.instruments import Sensors
from ..sensors.observation import Observation
from .assembly import Assembly
from .faults import SLACK, Faults, payload_scenes
from .rest_shape import rest_shape
from .singularity import NEAR, Singularity
from .validity import ValidityWatch


class Simulation:
    """State of a scene and the compiled step that advances it.

    Attributes
    ----------
    x, v : (n,) unknowns and their rates; the first m are the joint coordinates of the ERLS
    time : s
    status : 0, or a key of acceleration.REASONS; a failed step leaves the last good state
    torque : (3, m) at start, middle and end of the coming step, N m (N for prismatic joints)
    motion : (3, 3, m) prescribed position, velocity, acceleration of held joints at the same times
    load : (3, 2, L, 6) forces and moments on the links' ends at the same times, N and N m, in beam axes and
        in base axes
    faults : what comes between commands and torques and between joints and sensors, or None
    """

    model: Model
    work: Workspace
    sensors: Sensors

    def __init__(
        self,
        scene: Scene,
        step: float | None = None,
        held: tuple[str, ...] = (),
        planar: bool | None = None,
        exact_faults: bool = False,
    ) -> None:
        self.held, self.planar, self.exact_faults = held, planar, exact_faults
        self.step_size = float(scene.solver.step if step is None else step)
        self.method = scene.solver.method
        self.option = float(scene.solver.spectral_radius)
        self.advance: Callable[..., int] | None = None
        self.limit = np.array([j.effort_limit or np.inf for j in scene.joints])
        m = len(scene.joints)
        self.torque, self.motion = np.zeros((3, m)), np.zeros((3, 3, m))
        links = len(scene.links)
        self._torques, self._loads = Jumps(m), Jumps(12 * links)
        self._fresh, self._courses = True, False
        self.energies = np.zeros(3)
        self.faults: Faults | None = None
        self._plants = self._build(scene)
        self.scene = scene
        n = self._plants[0][1].unknowns
        self._rates = Rates(n, self.step_size)
        self.x, self.v, self._acceleration = np.zeros(n), np.zeros(n), np.zeros((2, n))
        self._tie()
        self.assembly: Assembly | None = None
        self.singularity: Singularity | None = None
        self._begin_with(self.model)
        self.time = 0.0
        self.status = OK
        if scene.faults:
            self.faults = Faults(scene, self.step_size, self.limit, exact_faults)
        self.reset()

    def _build(self, scene: Scene) -> list[tuple[float, Model]]:
        """Models for each payload that the scene's faults bring, and the steps from which on they hold."""
        variants = payload_scenes(scene, self.step_size, self.exact_faults)
        planar = self.planar
        if planar is None and len(variants) > 1:
            planar = all(is_planar(variant) for _, variant in variants)
        built = [(step, build_model(variant, planar, self.held)) for step, variant in variants]
        if any(model.unknowns != built[0][1].unknowns for _, model in built):
            raise SceneError(f"{scene.name}: faults: a payload changes the robot's degrees of freedom")
        return built

    def _tie(self) -> None:
        """Tie every model to the state, so that a change in flight only takes another set."""
        first = workspace(self._plants[0][1].chain)
        if hasattr(self, "work"):
            first.external[:], first.loaded[:] = self.work.external, self.work.loaded
            first.course[:] = self.work.course
        self.load = first.course
        self._robots = []
        for _, model in self._plants:
            # what acts from outside, and what was seen, are the same whatever the robot carries
            work = workspace(
                model.chain,
                external=first.external,
                course=first.course,
                loaded=first.loaded,
                validity=first.validity,
            )
            for name in self.held:
                work.held[model.joint_links[joint_index(self.scene, name)]] = True
            robot = by_reference(Robot(model.chain, work, self.x, self.v, self.torque, self.motion))
            watch = ValidityWatch(model, first.validity, external=first.external, loaded=first.loaded)
            # readings leave what the step keeps alone
            reading = workspace(model.chain, held=work.held) if model.scene.sensors else work
            look = Observation(model)
            self._robots.append((model, work, robot, look, Sensors(model), reading, watch))
        if self.method in METHODS:
            # of one type, whatever they carry
            self.advance = entry(METHODS[self.method].step, robot, self.step_size, self.option, False)
        self._take_plant(0)

    def _take_plant(self, k: int) -> None:
        self._plant = k
        read = self.sensors.buffer if hasattr(self, "sensors") else 0.0
        (self.model, self.work, self.arrays, self.view, self.sensors, self._reading, self.watch) = (
            self._robots[k]
        )
        self.sensors.buffer[:] = read  # quaternions go on from it
        self._rates.free[:] = True
        self._rates.free[self.model.turned[self.work.held[self.model.joint_links]]] = False
        self._check: Generator[None] | None = None

    def set_faults(self, scene: Scene) -> None:
        """Take the faults of a scene that is otherwise this one's; what is on its way is forgotten.

        It allocates: not for the middle of a run that has deadlines.

        Raises
        ------
        SceneError, ArithmeticError
            where the robot with its payloads has no initial state; then nothing has changed
        """
        scene = scene.model_copy(update=opened(self.scene))
        plants = self._build(scene)
        if plants[0][1].unknowns != len(self.x):
            raise SceneError(f"{scene.name}: faults: a payload changes the robot's degrees of freedom")
        if plants[0][1].scene.links != self._plants[0][1].scene.links:
            self._begin_with(plants[0][1])
        self._plants, self.scene = plants, scene
        steps = self.faults.step if self.faults else round(self.time / self.step_size)
        self.faults = Faults(scene, self.step_size, self.limit, self.exact_faults) if scene.faults else None
        self._tie()
        if self.faults is not None:
            self.faults.begin(round(steps), self.torque[2])
            self._change_payload()
        self.prepare()

    def _change_payload(self) -> bool:
        """Take the model that holds from the coming step on; whether it is another."""
        assert self.faults is not None
        now = self.faults.step + SLACK
        k = max(k for k, (step, _) in enumerate(self._plants) if step <= now)
        changed = k != self._plant
        if changed:
            self._take_plant(k)
        return changed

    def reset(self) -> None:
        """Return to the scene's initial state; time starts again at zero."""
        if self.faults is not None:
            self.faults.reset()
            self._take_plant(0)
        self.x[:], self.v[:] = self._first
        if self.singularity is not None:
            self.singularity.begin()
        self.torque[:] = 0.0
        self.motion[:, 0], self.motion[:, 1] = self.model.shown(self.x), self.model.shown(self.v)
        self.apply(None)
        self.time = 0.0
        self.status = OK
        self.prepare()
        self.watch.begin()
        self.sensors.begin()
        self._check = None

    def assemble(self) -> None:
        """Close the loops by moving passive joints, and let the robot come to rest where the scene says so.

        Raises
        ------
        SceneError
            with the gap, where that can't be
        """
        assert self.assembly is not None
        self._close(self.assembly, self.x, self.v)

    def _close(self, assembly: Assembly, x: np.ndarray, v: np.ndarray) -> None:
        model = assembly.model
        fixed = model.actuated.copy()
        fixed[[joint_index(self.scene, name) for name in self.held]] = True
        x[:] = assembly.position(x, fixed)
        copy_to_motors(model, x)
        if self.scene.initial.shape == "static":
            x[:], _ = assembly.rest(x, fixed)
        v[:] = assembly.velocity(x, v, fixed)
        copy_to_motors(model, v)

    def _begin_with(self, model: Model) -> None:
        """Find the initial state of the scene with this model; where there is none nothing has changed.

        Newton's iterations take as long as hundreds of steps, so a reset returns to what was found once.
        """
        m, scene = model.joints, self.scene
        x, v = np.zeros(model.unknowns), np.zeros(model.unknowns)
        x[:m], v[:m] = scene.start("position"), scene.start("velocity")
        for y in (x, v):
            copy_to_motors(model, y)
        if scene.loops:
            assembly = Assembly(model)
            self._close(assembly, x, v)
            self.assembly, self.singularity = assembly, Singularity(assembly, x)
        elif scene.initial.shape == "static":
            x[:] = rest_shape(model, x[:m])
        self._first = x, v

    def start_at(self, scene: Scene) -> None:
        """Take the start of a scene that is otherwise this one's; it allocates.

        Raises
        ------
        SceneError, ArithmeticError
            where there is no such state; then nothing has changed
        """
        before, self.scene = self.scene, scene
        try:
            check_zeroed(self.model, scene.start("position"))
            self._begin_with(self.model)
        except BaseException:
            self.scene = before
            raise
        self.reset()

    def prepare(self) -> None:
        """Set what the integrator keeps from step to step; needed after any change of x or v from outside."""
        if self.advance is not None:
            self.status = self.advance(self.arrays, self.step_size, self.option, True)
        self._torques.begin(self.torque[0])
        self._loads.begin(self.load[0].ravel())
        self._rates.begin(self.v)
        self._fresh = True

    def warm(self) -> None:
        """Compile (or load) everything a step needs, leaving the state as it is."""
        if self.advance is None:
            return
        x, v, seen = self.x.copy(), self.v.copy(), self.work.validity.copy()
        time = self.time
        self.status = self.advance(self.arrays, self.step_size, self.option, False)
        self.sense()
        self.look()
        self.energy()
        self.x[:], self.v[:] = x, v
        self.time, self.status = time, OK
        self.prepare()
        self.watch.look(self.x, self.v, self.work.arrival)
        self.sensors.begin()
        self.work.validity[:] = seen

    def command(self, torque: np.ndarray) -> None:
        """Hold a torque (m,) from the next step on, within the joints' effort limits."""
        if self.faults is not None:
            self.faults.arrive(torque)
            self.faults.drive(self.torque)
            return
        np.clip(torque, -self.limit, self.limit, out=self.torque[0])
        self.torque[1:] = self.torque[0]

    def apply(self, link: str | None, load: np.ndarray | None = None, base: bool = False) -> None:
        """Put a force and moment (6,), N and N m, on a link's end from the next step on, for the last ones.

        They are along the axes of the link's frame, or of the base's with `base`.  None takes all loads off.
        A load (3, 6) is that at start, middle and end of the next step; after it that at its end holds.
        """
        work = self.work
        if link is None:
            self.load[:] = 0.0
        else:
            n = link_index(self.scene, link)
            given = np.zeros(6) if load is None else np.asarray(load, dtype=float)
            if given.shape not in ((6,), (3, 6)) or not np.all(np.isfinite(given)):
                raise ValueError(
                    f"{self.scene.name}: load {load!r} on {link}; give six finite values, N and N m"
                )
            if self.model.planar and np.any(given.reshape(-1, 6)[:, [2, 3, 4]] != 0.0):
                raise ValueError(
                    f"{self.scene.name}: load {load!r} on {link} leaves the plane in which the robot moves;"
                    " give forces along x and y and moments about z, or build Simulation(..., planar=False)"
                )
            rows = given.reshape(-1, 2, 3)
            rows = rows if base else rows @ self.model.axes[n]
            self.load[:, 1 if base else 0, n] = rows.reshape(-1, 6)
            self._courses |= given.ndim == 2
        work.external[:] = self.load[0]
        work.loaded[:] = np.any(self.load != 0.0, axis=(0, 2, 3))

    def step(self, length: float | None = None, jumped: bool = False) -> int:
        """Advance by one step with the torque and motion at hand.  Returns the status.

        length : s, of a part of a step; the whole where None
        jumped : whether torque or motion is another than the last step ended with: the method begins anew
        """
        assert self.advance is not None
        faults, h, part = self.faults, self.step_size, 1.0
        if length is not None:
            h, part = length, length / self.step_size
        if faults is not None:
            faults.drive(self.torque, part)
            jumped = self._change_payload() or jumped
        if jumped:
            self.status = self.advance(self.arrays, h, self.option, True)
            if self.status != OK:
                return self.status
        self.status = self.advance(self.arrays, h, self.option, False)
        if self.status == OK:
            self.time += h
            self.note_step(length is None and not jumped)
            if self.singularity is not None:
                self.singularity.look(self.work)
            if faults is not None:
                faults.advance(part)
        elif self.status != NOT_VALID and self.singularity is not None and self.singularity.now < NEAR:
            self.status = LOOP_OPEN
        return self.status

    def note_step(self, whole: bool = True) -> None:
        """Tell the sensors of a step that was taken under the torque and loads at hand.

        whole : it has the scene's length, and goes on with what the last one ended with
        """
        if self.sensors.names:
            self._torques.step(self.torque[0], self.torque[2])
            self._loads.step(self.load[0].ravel(), self.load[2].ravel())
            if whole:
                self._rates.step(self.v)
            else:
                self._rates.begin(self.v)
            self._fresh = False
        if self._courses:  # given for one step, now held
            self.load[:2] = self.load[2]
            self._courses = False

    def check(self) -> bool:
        """Look at what the watch does not see in every step; False, and a status, where a limit is passed."""
        if self.status == OK and not self.watch.look(self.x, self.v, self.work.arrival):
            self.status = NOT_VALID
        return self.status == OK

    def glance(self, begin: bool) -> None:
        """Check bit by bit, a bit a call, for who has deadlines; `begin` a check unless one is under way."""
        if begin and self._check is None:
            self._check = self.watch.glances(self.x.copy(), self.v.copy(), self.work.arrival.copy())
        if self._check is not None and next(self._check, True):
            self._check = None
            if self.status == OK and self.watch.beyond:
                self.status = NOT_VALID

    @property
    def reason(self) -> str:
        """The status in words."""
        passed = self.watch.sentences("stop") if self.status == NOT_VALID else ()
        return passed[0] if passed else REASONS[self.status]

    def look(self) -> Observation:
        """Nodes and links as they are now, in buffers that the next look overwrites."""
        self.view.look(self.work, self.x)
        return self.view

    def sense(self) -> dict[str, np.ndarray]:
        """Readings of the scene's sensors by name (instruments.py), in buffers that the next call overwrites.

        Of what the step resolves accelerations are those of the equations at this state, under the loads in
        force; of loads that are held and jump from step to step, under the mean of before and after the jump
        (end_acceleration.py).  Frequencies that the step does not resolve are damped in them.
        """
        if self.sensors.names:
            method = METHODS.get(self.method)
            smoothing = 0.0 if method is None else method.SMOOTHING
            a, felt = self._acceleration
            a[:] = 0.0 if smoothing == 0.0 else self.work.arrival
            if smoothing == 0.0:
                a[self.model.turned] = self.motion[0 if self._fresh else 2, 2]
            end_accelerations(
                self.model, self._reading, self.x, self.v, self._torques, self._loads, self._rates,
                None if smoothing is None else smoothing * self.step_size, self._fresh, a, felt,
            )  # fmt: skip
            self.sensors.look(self.look(), self._reading, self.x, self.v, a, felt)
        return self.sensors.values

    def energy(self) -> np.ndarray:
        """(3,) kinetic, elastic and gravitational energy, J, in a buffer that the next call overwrites."""
        energy(self.model.chain, self.work, self.x, self.v, self.energies)
        return self.energies

    def joint_position(self) -> np.ndarray:
        """(m,) what the motors' encoders show, rad or m (Model.shown)."""
        return self._measured("position", self.model.shown(self.x))

    def joint_velocity(self) -> np.ndarray:
        """(m,) rates of the joints, rad/s or m/s."""
        return self._measured("velocity", self.model.shown(self.v))

    def joint_effort(self) -> np.ndarray:
        """(m,) torques that the motors' sensors show, of the step that led to this state, N m or N."""
        return self._measured("effort", self.torque[2])

    def _measured(self, signal: str, values: np.ndarray) -> np.ndarray:
        return values if self.faults is None else self.faults.measure(signal, values)

    def follow_motion(self) -> None:
        """Put the joints whose motion is prescribed where it says they are; needs prepare() afterwards."""
        for y, given in zip((self.x, self.v), self.motion[0], strict=False):
            held = self.work.held[self.model.joint_links]
            y[: self.model.joints][held] = given[held]
            copy_to_motors(self.model, y)
        drive_joints(self.model.chain, self.work, self.motion[0], self.x, self.v, np.zeros(self.x.size))


def link_index(scene: Scene, name: str) -> int:
    """Place of a link in the scene, by name."""
    names = [link.name for link in scene.links]
    if name not in names:
        raise SceneError(f"{scene.name}: no link {name!r}; give one of {', '.join(names)}")
    return names.index(name)


def copy_to_motors(model: Model, y: np.ndarray) -> None:
    """Set the angles of motors behind springs as if the springs were at rest."""
    motors = np.flatnonzero(model.motor >= 0)
    y[model.motor[motors]] = y[motors]


def joint_index(scene: Scene, name: str) -> int:
    """Place of a joint in q, by name."""
    names = scene.joint_names
    if name not in names:
        raise SceneError(f"{scene.name}: no joint {name!r}; give one of {', '.join(names)}")
    return names.index(name)
