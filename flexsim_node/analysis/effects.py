"""What each effect changes at the tip, measured on the scene: on its own motion and over its envelope."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..model.dofs import is_planar
from ..motion.decision import Change
from ..motion.jumps import torque_jumps
from ..motion.run import run
from ..scene.schema import HELD_BY_FRAMES, Scene, Undecided
from ..scene.torque_profile import torque_profile
from ..scene.variants import everything_open_on, is_on, with_effect

SAMPLES = 400  # of a run's tip
MOST_TORQUES = 20_000  # looked at for an envelope's largest
REST = 1e-9  # rad or m: joints that move no further are at rest
Drive = Callable[[float], np.ndarray] | None


class Trial:
    """A run of a scene that its effects and formulations are judged by.  Open effects are on.

    Parameters
    ----------
    scene : its formulation decided
    drive : torque (m,) as a function of time; the scene's own profile where None
    duration : s; the scene's own where None
    louder : times the torques, speeds at the start; beside : (m,) rad or m that the joints begin elsewhere

    Raises
    ------
    ArithmeticError
        where the scene itself does not run to the end
    """

    def __init__(
        self,
        scene: Scene,
        drive: Drive = None,
        duration: float | None = None,
        louder: float = 1.0,
        beside: np.ndarray | None = None,
    ) -> None:
        if scene.formulation == "auto":
            raise Undecided(f"{scene.name}: a trial is of one formulation; decide it first")
        self.scene = everything_open_on(scene)
        self.drive = drive or torque_profile(scene)
        self.own_drive, self.louder, self.beside = drive is None, louder, beside
        self.duration = scene.duration if duration is None else duration
        self.path, trouble = self._tip(self.scene, keep=True)
        if trouble:
            raise ArithmeticError(f"{scene.name}: the run that effects are judged by {trouble}")
        self.reach = float(np.max(np.linalg.norm(self.path - self.path[0], axis=-1)))

    def at_rest(self, tolerance: float) -> bool:
        """Whether its joints stand still, or its tips move by no more than a tolerance, m."""
        q = self.motion[0]
        return float(np.max(np.abs(q - q[0]))) <= REST or self.reach <= tolerance

    def of(self, scene: Scene) -> Trial:
        """The same run of another scene."""
        drive = None if self.own_drive else self.drive
        return Trial(scene, drive, self.duration, self.louder, self.beside)

    def _tip(self, scene: Scene, keep: bool = False) -> tuple[np.ndarray, str]:
        """Paths (K, tips, 3) of the tips, and why they ended early, or ""; `keep` what the joints did."""
        drive = self.drive or _no_torque(scene)
        if self.louder != 1.0 or self.beside is not None:
            start = {
                "position": scene.start("position") + (0.0 if self.beside is None else self.beside),
                "velocity": self.louder * scene.start("velocity"),
            }
            begun = {key: tuple(float(x) for x in values) for key, values in start.items()}
            scene = scene.model_copy(update={"initial": scene.initial.model_copy(update=begun)})
        jumps = torque_jumps(scene) if self.own_drive else []
        period = max(scene.solver.step, self.duration / SAMPLES)
        louder = self.louder
        try:
            own = run(scene, lambda t: louder * drive(t), self.duration, sample_period=period, jumps=jumps)
        except (ValueError, ArithmeticError) as problem:
            return np.zeros((0, 1, 3)), f"can't be simulated: {problem}"
        if keep:
            count = min(MOST_TORQUES, max(2, round(self.duration / scene.solver.step) + 1))
            efforts = louder * np.array([drive(t) for t in np.linspace(0.0, self.duration, count)])
            self.motion = own.joint_position, own.joint_velocity, efforts
        return own.link_end[:, list(scene.tips)], "" if own.status == "ok" else own.status

    def distance(self, scene: Scene) -> tuple[float, str]:
        """Largest distance, m, of a tip from that of the trial's own run; infinite with a reason."""
        path, trouble = self._tip(scene)
        if trouble:
            return float("inf"), trouble
        return float(np.max(np.linalg.norm(path - self.path, axis=-1))), ""

    def change(self, name: str) -> Change:
        """What switching one effect, or one link's flexibility, does."""
        on = is_on(self.scene, name)
        if self.scene.co_moving and name in HELD_BY_FRAMES:
            trouble = "can't be simulated: co-moving frames hold it by their geometry"
            return Change(name, on, float("inf"), float("inf"), trouble)
        change, trouble = self.distance(with_effect(self.scene, name, not on))
        return Change(name, on, change, change / self.reach if self.reach > 0.0 else 0.0, trouble)


def envelope_trials(scene: Scene, own: Trial, margin: float) -> list[Trial]:
    """The runs that stand for a scene's envelope, the widest first.

    The scene's own motion with `margin` times its torques and speeds, begun where it begins, and with its
    joints moved either way by what `margin` adds to how far they go; and as it is; each for `margin` times
    its duration.  What does not run to its end stands for nothing, and is shortened by halves.
    """
    q = own.motion[0]
    further = (margin - 1.0) * np.max(np.abs(q - q[0]), axis=0)
    if scene.loops:
        further *= np.array([joint.actuated for joint in scene.joints])
    drive = None if own.own_drive else own.drive
    wanted: list[tuple[float, np.ndarray | None]] = [
        (margin, None),
        (margin, further),
        (margin, -further),
        (1.0, None),
    ]
    found = []
    for louder, beside in wanted:
        for duration in (margin * own.duration, own.duration):
            try:
                found.append(Trial(scene, drive, duration, louder, beside))
            except ArithmeticError:
                continue
            break
    return found


def without_meaning(scene: Scene) -> set[str]:
    """Effects that no motion of the scene has: nothing in it has a part in them."""
    joints = scene.joints
    found = {
        "gravity": not any(scene.gravity),
        "damping": scene.damping.alpha == 0.0 == scene.damping.beta,
        "joint_friction": not any(j.viscous_friction or j.coulomb_friction for j in joints),
        "rotor_inertia": not any(j.rotor_inertia for j in joints),
        "joint_elasticity": not any(j.stiffness for j in joints),
    }
    if is_planar(scene) and not any(f.kind == "payload" for f in scene.faults):
        found |= {"torsion": True, "bending_y": True}
    return {name for name, absent in found.items() if absent}


def _no_torque(scene: Scene) -> Callable[[float], np.ndarray]:
    zero = np.zeros(len(scene.joints))
    return lambda t: zero
