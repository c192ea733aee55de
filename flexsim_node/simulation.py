"""A robot in motion: one state, advanced step by step.  Offline runs and the real-time loop share it."""

from __future__ import annotations

import numpy as np

from .acceleration import LOOP_OPEN, NOT_VALID, OK, REASONS, drive_joints
from .assembly import Assembly
from .binding import STEPPERS, bind
from .chain import workspace
from .energy import energy
from .integrators import METHODS
from .model import Model, build_model
from .observation import Observation
from .scene import Scene, SceneError
from .sensors import Sensors
from .singularity import NEAR, Singularity
from .statics import rest_shape
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
    """

    def __init__(
        self,
        scene: Scene,
        step: float | None = None,
        held: tuple[str, ...] = (),
        planar: bool | None = None,
    ) -> None:
        self.model: Model = build_model(scene, planar, driven=held)
        self.scene = scene = self.model.scene  # its open effects decided
        self.work = workspace(self.model.chain)
        self.step_size = scene.solver.step if step is None else step
        m, n = self.model.joints, self.model.unknowns
        for name in held:
            k = joint_index(scene, name)
            self.work.held[self.model.joint_links[k]] = True
        self.x, self.v = np.zeros(n), np.zeros(n)
        self.torque, self.motion = np.zeros((3, m)), np.zeros((3, 3, m))
        self.limit = np.array([j.effort_limit or np.inf for j in scene.joints])
        self.view = Observation(self.model)
        self.sensors = Sensors(self.model)
        self.assembly = Assembly(self.model) if scene.loops else None
        self.singularity: Singularity | None = None
        self.energies = np.zeros(3)
        self._acceleration = np.zeros(n)
        self.method = scene.solver.method
        self.advance = STEPPERS.get(self.method)
        self._bound = bind(self.model.chain, self.work, self.x, self.v, self.torque, self.motion)
        self.option = scene.solver.spectral_radius
        self.watch = ValidityWatch(self.model, self.work.validity)
        self.time = 0.0
        self.status = OK
        self.reset()

    def reset(self) -> None:
        """Return to the scene's initial state; time starts again at zero."""
        initial, m = self.scene.initial, self.model.joints
        self.x[:], self.v[:] = 0.0, 0.0
        self.x[:m] = self.scene.start("position")
        self.v[:m] = self.scene.start("velocity")
        for y in (self.x, self.v):
            copy_to_motors(self.model, y)
        if self.assembly is not None:
            self.assemble()
            self.singularity = Singularity(self.assembly, self.x)
        elif initial.shape == "static":
            self.x[:] = rest_shape(self.model, self.x[:m])
        self.torque[:] = 0.0
        self.motion[:, 0], self.motion[:, 1] = self.joint_position(), self.joint_velocity()
        self.apply(None)
        self.time = 0.0
        self.status = OK
        self.prepare()
        self.watch.clear()

    def assemble(self) -> None:
        """Close the loops by moving passive joints, and let the robot come to rest where the scene says so.

        Raises
        ------
        SceneError
            with the gap, where that can't be
        """
        assert self.assembly is not None
        fixed = self.model.actuated | self.work.held[self.model.joint_links]
        self.x[:] = self.assembly.position(self.x, fixed)
        copy_to_motors(self.model, self.x)
        if self.scene.initial.shape == "static":
            self.x[:], _ = self.assembly.rest(self.x, fixed)
        self.v[:] = self.assembly.velocity(self.x, self.v, fixed)
        copy_to_motors(self.model, self.v)

    def prepare(self) -> None:
        """Set what the integrator keeps from step to step; needed after any change of x or v from outside."""
        start = getattr(METHODS.get(self.method), "start", None)
        if start is not None:
            self.status = start(
                self.model.chain,
                self.work,
                self.x,
                self.v,
                self.torque[0],
                self.motion[0],
                self.step_size,
            )

    def warm(self) -> None:
        """Compile (or load) everything a step needs, leaving the state as it is."""
        if self.advance is None:
            return
        x, v, seen = self.x.copy(), self.v.copy(), self.work.validity.copy()
        time = self.time
        self.step()
        self.sense()
        self.look()
        self.energy()
        self.x[:], self.v[:] = x, v
        self.time, self.status = time, OK
        self.prepare()
        self.watch.look(self.x)
        self.work.validity[:] = seen

    def command(self, torque: np.ndarray) -> None:
        """Hold a torque (m,) from the next step on, within the joints' effort limits."""
        np.clip(torque, -self.limit, self.limit, out=self.torque[0])
        self.torque[1:] = self.torque[0]

    def apply(self, link: str | None, load: np.ndarray | None = None, base: bool = False) -> None:
        """Put a force and moment (6,), N and N m, on a link's end from the next step on, for the last ones.

        They are along the axes of the link's frame, or of the base's with `base`.  None takes all loads off.
        """
        work = self.work
        if link is None:
            work.external[:] = 0.0
            work.loaded[:] = False
            return
        n = link_index(self.scene, link)
        given = np.zeros(6) if load is None else np.asarray(load, dtype=float)
        if given.shape != (6,) or not np.all(np.isfinite(given)):
            raise ValueError(f"{self.scene.name}: load {load!r} on {link}; give six finite values, N and N m")
        rows = given.reshape(2, 3)
        work.external[1 if base else 0, n] = (rows if base else rows @ self.model.axes[n]).ravel()
        work.loaded[:] = np.any(work.external != 0.0, axis=(1, 2))

    def step(self) -> int:
        """Advance by one step with the torque and motion at hand.  Returns the status."""
        assert self.advance is not None
        self.status = self.advance(self._bound, self.step_size, self.option)
        if self.status == OK:
            self.time += self.step_size
            if self.singularity is not None:
                self.singularity.look(self.work)
        elif self.status != NOT_VALID and self.singularity is not None and self.singularity.now < NEAR:
            self.status = LOOP_OPEN
        return self.status

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
        """Readings of the scene's sensors by name (see sensors.py), in buffers that the next call overwrites.

        Accelerations are those that the method carries, in which frequencies that the step does not resolve
        are damped; of a method that carries none, those of the equations under the torque at the step's end.
        """
        if self.sensors.names:
            view = self.look()
            if getattr(METHODS.get(self.method), "start", None) is not None:
                self.sensors.look(view, self.work, self.x, self.v, self.work.memory)
            else:
                self._acceleration[self.model.turned] = self.motion[2, 2]
                self.sensors.look_exactly(view, self.work, self.x, self.v, self.torque[2], self._acceleration)
        return self.sensors.values

    def energy(self) -> np.ndarray:
        """(3,) kinetic, elastic and gravitational energy, J, in a buffer that the next call overwrites."""
        energy(self.model.chain, self.work, self.x, self.v, self.energies)
        return self.energies

    def joint_position(self) -> np.ndarray:
        """(m,) what the motors' encoders show, rad or m (Model.shown)."""
        return self.model.shown(self.x)

    def joint_velocity(self) -> np.ndarray:
        """(m,) rates of the joints, rad/s or m/s."""
        return self.model.shown(self.v)

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
