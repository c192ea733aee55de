"""Offline simulation of a scene; what it leaves to `auto` is decided first."""

from __future__ import annotations

from collections.abc import Iterable

from ..motion.run import Motion, Run, Torque, Wrench, run
from ..scene.schema import Scene
from .decide import decide


def simulate(
    scene: Scene,
    torque: Torque = None,
    duration: float = 1.0,
    sample_period: float | None = None,
    prescribed: Motion | None = None,
    wrench: Wrench | None = None,
    jumps: Iterable[float] = (),
    exact_faults: bool = False,
) -> Run:
    """Simulate a scene for `duration` seconds, as fast as it goes.

    Parameters
    ----------
    torque : a callable t -> (m,), or an array (K, m) held between samples, zero at passive joints; the
        scene's own profile where None
        (where the scene has faults, each sample's torque is a command, held to the next)
    sample_period : s between samples; the scene's step where None.  Steps are as long as the scene says,
        shortened so that a whole number of them makes a period
    wrench : link name to a callable t -> (6,), force (N) and moment (N m) on that link's end along the axes
        of its frame; `base:` before the name takes the base's axes
    prescribed : joint name to a callable t -> (position, velocity, acceleration) that the joint follows
    jumps : s, where a torque, a wrench or a prescribed motion given as a callable jumps: a step ends there,
        with what was before, and the next begins with what is after.  Those of the scene's own torques are
        known
    exact_faults : whether faults begin, end and deliver commands at their instants, by dividing steps, rather
        than with the next whole step as in the node

    Raises
    ------
    ValueError
        for a duration, period or torque that can't be
    """
    _, decision = decide(scene)
    return run(
        scene, torque, duration, sample_period, prescribed, wrench, jumps, exact_faults, decision=decision
    )
