"""The robot's part of a report: tracking, torques, deflection, vibration, stress."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexsim_node import Scene

from ..bag import Bag, BagError
from ..bag.robot import robot_in
from ..figures.style import GHOST, INK
from . import pictures, tracking
from .harmonics import Harmonic
from .motion import JOINT_FIELDS, Joints, joints, layout
from .page import Section
from .reading import Reading
from .stress import MOST, LinkStress, Stresses
from .vibration import TIP, Vibration, vibration

MILLIMETRES, MEGAPASCALS = 1e3, 1e-6
SECONDS = "time, s"
SHOWN_MODES = 6
# Of a mode's damping ratio, from which it is called uncertain.
UNCERTAIN = 0.2


@dataclass
class RobotPart:
    """What is known of a robot, as sections of a page and as figures for programs."""

    sections: list[Section] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)


def has_robot(bag: Bag) -> bool:
    """Say whether a bag holds a robot's motion."""
    robot = robot_in(bag)
    return robot.joints is not None or robot.state is not None


def fields(bag: Bag) -> dict[str, list[str]]:
    """Return what `robot_part` needs of a bag: fields by topic."""
    found: dict[str, list[str]] = {}
    robot = robot_in(bag)
    if robot.joints is not None:
        found |= tracking.fields(bag, robot.joints) | {robot.joints: JOINT_FIELDS}
    return found if robot.state is None else found | {robot.state: TIP}


def stress_of(bag: Bag, scene: Scene | None) -> Stresses | None:
    """Return what takes up the stresses of a bag's elastic states; None where they can't be known."""
    topic, known = robot_in(bag).state, layout(bag)
    return None if topic is None or scene is None or known is None else Stresses(bag, topic, scene, known)


def robot_part(reading: Reading, scene: Scene | None, why_not: str, stresses: Stresses | None) -> RobotPart:
    """Look at a bag's robot.

    why_not : why there is no scene
    stresses : that took up all elastic states, where they can be known
    """
    bag = reading.bag
    part = RobotPart()
    measured = wanted = None
    robot = robot_in(bag)
    section = Section("Tracking error")
    part.sections.append(section)
    if robot.others:
        others = ", ".join(robot.others)
        section.say(f"Of the bag's robots this is {robot.node}; further ones, for --robot: {others}.")
    if robot.joints is not None:
        try:
            measured = joints(reading, robot.joints)
            wanted = tracking.wanted(reading, measured)
        except BagError as problem:
            section.missing(str(problem))
    tracked(section, part.figures, measured, wanted)
    part.sections.append(torques(part.figures, measured, scene))
    topic = robot.state
    if topic is None:
        section = Section("Vibration and stress")
        section.missing(
            "Tip deflection, vibration and stress: the bag holds no elastic states "
            "(flexsim_msgs/msg/ElasticState); record ~/elastic_state and ~/elastic_layout."
        )
        part.sections.append(section)
        part.figures |= {"deflection": None, "vibration": None, "stress": None}
        return part
    known = layout(bag)
    try:
        swing = vibration(reading, topic, known, moving(measured, wanted))
    except BagError as problem:
        section = Section("Vibration")
        section.missing(str(problem))
        part.sections.append(section)
        part.figures |= {"deflection": None, "vibration": None}
    else:
        part.sections.append(deflection(part.figures, swing))
        part.sections.append(vibrations(part.figures, swing, measured, scene))
    part.sections.append(stress(part.figures, bag.topic(topic).count, scene, why_not, stresses))
    return part


def moving(measured: Joints | None, wanted: tracking.Wanted | None) -> Any:
    """Return times and whether the joints were to move then; None where it is not known."""
    if measured is None or wanted is None:
        return None
    steps = np.abs(np.diff(wanted.position, axis=0, prepend=wanted.position[:1]))
    return measured.series.time, np.nan_to_num(steps).max(axis=1) > 0.0


def tracked(
    section: Section, figures: dict[str, Any], measured: Joints | None, wanted: tracking.Wanted | None
) -> None:
    """Say how well the joints followed, or else how they moved."""
    figures["joints"] = figures["tracking"] = None
    if measured is None or measured.position is None:
        section.missing("Joint motion: the bag holds no joint states with positions (/joint_states).")
        return
    time, position = measured.series.time, measured.position
    for note in measured.series.notes:
        section.say(note)
    moves: dict[str, Any] = {}
    for k, name in enumerate(measured.names):
        moves[name] = {"least": float(position[:, k].min()), "largest": float(position[:, k].max())}
        if measured.velocity is not None:
            moves[name]["fastest"] = float(np.abs(measured.velocity[:, k]).max())
    figures["joints"] = moves
    table = section.table
    if wanted is None or not np.isfinite(wanted.position).any():
        section.title = "Joint motion"
        section.missing(
            "Tracking error: the bag does not say where the joints were to be. Record what does: "
            "joint_trajectory (trajectory_msgs/JointTrajectory), a controller's state "
            "(control_msgs/JointTrajectoryControllerState), or positions as sensor_msgs/JointState."
        )
        section.picture(
            pictures.curves("Joint positions", time, position, measured.names, SECONDS, "position, rad or m")
        )
    else:
        found = tracking.errors(wanted, measured)
        figures["tracking"] = {
            "topic": wanted.topic, "kind": wanted.kind,
            "joints": {e.joint: {"rms": e.rms, "largest": e.largest, "at": e.at, "last": e.last}
                       for e in found},
        }  # fmt: skip
        section.say(f"Measured ({measured.series.topic}) less wanted ({wanted.topic}, {wanted.kind}).")
        table(["joint", "rms, mrad or mm", "largest, mrad or mm", "at, s", "at the end, mrad or mm"],
              [[e.joint, 1e3 * e.rms, 1e3 * e.largest, e.at, 1e3 * e.last] for e in found])  # fmt: skip

        def both(axes: Any) -> None:
            for k in range(len(measured.names)):
                label = "wanted" if k == 0 else None
                pictures.plot(axes, time, wanted.position[:, k], color=INK, linestyle="--", label=label)
            pictures.lines(axes, time, position, measured.names)
            axes.set(xlabel=SECONDS, ylabel="position, rad or m")

        section.picture(pictures.svg(both, "Joint positions, wanted and measured"))
        off = 1e3 * (position - wanted.position)
        section.picture(
            pictures.curves("Tracking error", time, off, measured.names, SECONDS, "error, mrad or mm")
        )
    table(
        ["joint", "least, rad or m", "largest, rad or m", "fastest, rad/s or m/s"],
        [[name, m["least"], m["largest"], m.get("fastest", "–")] for name, m in moves.items()],
    )


def torques(figures: dict[str, Any], measured: Joints | None, scene: Scene | None) -> Section:
    """Say what the joints' torques were."""
    section = Section("Torques")
    figures["torque"] = None
    if measured is None or measured.effort is None:
        section.missing("Torques: the bag's joint states bear no effort.")
        return section
    time, effort = measured.series.time, measured.effort
    limits: dict[str, float] = {}
    if scene is not None:
        named = zip(scene.joint_names, scene.joints, strict=True)
        limits = {name: j.effort_limit for name, j in named if j.effort_limit is not None}
    found: dict[str, Any] = {}
    for k, name in enumerate(measured.names):
        column = effort[:, k]
        found[name] = {
            "rms": float(np.sqrt(np.mean(column**2))),
            "largest": float(np.abs(column).max()),
            "at": float(time[np.argmax(np.abs(column))]),
        }
        if name in limits:
            found[name] |= {
                "limit": limits[name],
                "at_limit": float(np.mean(np.abs(column) >= limits[name] * (1.0 - 1e-9))),
            }
        if measured.velocity is not None:
            power = column * measured.velocity[:, k]
            found[name]["largest_power"] = float(np.abs(power).max())
            found[name]["work"] = float(np.trapezoid(power, time))
    figures["torque"] = found
    section.table(
        ["joint", "rms, N m or N", "largest", "at, s", "limit", "time at it, %", "power, W", "work, J"],
        [[name, t["rms"], t["largest"], t["at"], t.get("limit", "–"),
          100.0 * t["at_limit"] if "at_limit" in t else "–", t.get("largest_power", "–"), t.get("work", "–")]
         for name, t in found.items()],
    )  # fmt: skip
    section.picture(
        pictures.curves("Joint torques", time, effort, measured.names, SECONDS, "torque, N m, or force, N")
    )
    return section


def deflection(figures: dict[str, Any], swing: Vibration) -> Section:
    """Say how far the tip is from where the rigid robot has it."""
    section = Section("Tip deflection")
    for note in swing.series.notes:
        section.say(note)
    time, off, size = swing.time, MILLIMETRES * swing.deflection, swing.size
    k = int(np.argmax(size))
    figures["deflection"] = {
        "rms": float(np.sqrt(np.mean(size**2))), "largest": float(size[k]), "at": float(time[k]),
        "mean": swing.deflection.mean(axis=0).tolist(), "last": float(size[-1]),
    }  # fmt: skip
    section.say("From the tip of the equivalent rigid-link system to the tip, in the base frame.")
    section.table(
        ["rms, mm", "largest, mm", "at, s", "at the end, mm"],
        [[MILLIMETRES * figures["deflection"][n] for n in ("rms", "largest")] + [float(time[k])]
         + [MILLIMETRES * float(size[-1])]],
    )  # fmt: skip

    def draw(axes: Any) -> None:
        pictures.lines(axes, time, off, ["x", "y", "z"])
        pictures.plot(axes, time, MILLIMETRES * size, color=INK, linewidth=0.7, label="length")
        axes.set(xlabel=SECONDS, ylabel="deflection, mm")

    section.picture(pictures.svg(draw, "Tip deflection"))
    return section


def vibrations(
    figures: dict[str, Any], swing: Vibration, measured: Joints | None, scene: Scene | None
) -> Section:
    """Say how the tip swings: spectrum, natural frequencies and damping ratios."""
    section = Section("Vibration")
    figures["vibration"] = {
        "peaks": list(swing.peaks), "harmonics": [told(h) for h in swing.harmonics], "ring_downs": [],
        "why_no_ring_down": list(swing.why_not), "scene_frequencies": None,
    }  # fmt: skip
    decays = figures["vibration"]["ring_downs"]
    for d in swing.decays:
        modes = [
            {"frequency": m.frequency, "damping_ratio": m.damping, "spread": m.spread,
             "amplitude": m.amplitude, "uncertain": m.spread > UNCERTAIN * abs(m.damping)}
            for m in d.modes[:SHOWN_MODES]
        ]  # fmt: skip
        decays.append(
            {"begin": d.begin, "end": d.end, "explained": d.explained, "modes": modes,
             "harmonics": [told(h) for h in d.harmonics]}
        )  # fmt: skip
    if not len(swing.frequency):
        section.missing("Spectrum: there are too few elastic states.")
        return section
    begin = swing.decays[0].begin if swing.decays else float(swing.time[-1])
    own = scene_frequencies(scene, measured, begin)
    figures["vibration"]["scene_frequencies"] = own

    def draw(axes: Any) -> None:
        until = highest(swing, own)
        top = swing.frequency <= until
        axes.semilogy(swing.frequency[top], MILLIMETRES * swing.amplitude[top], color=pictures.LINES[0])
        axes.set_xlim(0.0, until)
        for n, f in enumerate(f for f in own or [] if f <= until):
            label = "scene, joints locked" if n == 0 else None
            axes.axvline(f, color=GHOST, linestyle=":", linewidth=1.4, label=label)
        for n, m in enumerate(swing.decays[0].modes[:SHOWN_MODES] if swing.decays else ()):
            label = "ring-down" if n == 0 else None
            axes.axvline(m.frequency, color=pictures.LINES[1], linewidth=1.0, label=label)
        for n, h in enumerate(h for h in swing.harmonics if h.frequency <= until):
            label = "harmonics" if n == 0 else None
            axes.plot(h.frequency, MILLIMETRES * h.amplitude, "v", color=GHOST, markersize=5, label=label)
        axes.set(xlabel="frequency, Hz", ylabel="amplitude, mm")

    section.picture(pictures.svg(draw, "Spectrum of the tip's deflection"))
    section.say(
        "A line's amplitude is that of a steady sine there, along the direction in which it is largest; what "
        "dies away within a piece of the run reads less."
    )
    others = [(h.frequency, h.of) for h in swing.harmonics]
    others += [(h.frequency, h.of) for d in swing.decays for h in d.harmonics]
    if others:
        section.say(
            "Harmonics, no modes of their own: "
            + ", ".join(f"{f:.2f} Hz ({of})" for f, of in dict(sorted(others)).items()) + "."
        )  # fmt: skip
    if swing.decays:
        section.say(
            "Modes of the free decays, by the matrix pencil, together with whatever held the joints: a "
            "controller's damping is in them. Spread: half of the range of the damping ratio over parts of "
            "the decay and orders of the model."
        )
        section.table(
            ["from, s", "to, s", "frequency, Hz", "damping ratio, %", "± spread, %", "amplitude, mm", ""],
            [[d["begin"], d["end"], m["frequency"], 100.0 * m["damping_ratio"], 100.0 * m["spread"],
              MILLIMETRES * m["amplitude"], "uncertain" if m["uncertain"] else ""]
             for d in decays for m in d["modes"]],
        )  # fmt: skip
        best = swing.decays[0]
        inside = (swing.time >= best.begin) & (swing.time <= best.end)
        off = swing.deflection[inside] - swing.deflection[inside].mean(axis=0)
        main = MILLIMETRES * off @ np.linalg.svd(off, full_matrices=False)[2][0]
        t, first = swing.time[inside], best.modes[0]

        def decay(axes: Any) -> None:
            pictures.plot(axes, t, main, color=pictures.LINES[0], label="tip, main direction")
            rate = 2.0 * np.pi * first.frequency * first.damping
            bound = MILLIMETRES * first.amplitude * np.exp(-rate * (t - best.begin))
            for sign in (1.0, -1.0):
                axes.plot(t, sign * bound, color=pictures.LINES[1], linestyle="--",
                          label=f"{first.frequency:.2f} Hz, {100 * first.damping:.2f} %"
                          if sign > 0 else None)  # fmt: skip
            axes.set(xlabel=SECONDS, ylabel="mm")

        section.picture(pictures.svg(decay, "Largest ring-down and its first mode's envelope"))
    else:
        section.missing(
            "Damping: no stretch of the run is a free decay (at least three periods of damped sines that "
            "explain 98 % of it); let the robot ring with the joints held."
        )
        for reason in swing.why_not:
            section.say(f"Looked at {reason}." if reason.startswith("from ") else f"{reason}.".capitalize())
    if own:
        section.say(
            f"The scene's own natural frequencies with locked joints, at {begin:.2f} s: "
            + ", ".join(f"{f:.2f}" for f in own) + " Hz."
        )  # fmt: skip
    return section


def told(harmonic: Harmonic) -> dict[str, Any]:
    """Return a harmonic for programs."""
    return {"frequency": harmonic.frequency, "amplitude": harmonic.amplitude, "of": harmonic.of}


def highest(swing: Vibration, own: list[float] | None) -> float:
    """Return up to where a spectrum is shown, Hz: what holds all but a millionth of its power."""
    power = np.cumsum(swing.amplitude**2)
    k = int(np.searchsorted(power, (1.0 - 1e-6) * power[-1]))
    modes = [m.frequency for d in swing.decays[:1] for m in d.modes[:SHOWN_MODES]]
    wanted = max([float(swing.frequency[k]), 1.3 * max(modes, default=0.0), 1.2 * (own[0] if own else 0.0)])
    return min(wanted, float(swing.frequency[-1]))


def scene_frequencies(scene: Scene | None, measured: Joints | None, time: float) -> list[float] | None:
    """Return the scene's first natural frequencies with locked joints, where these were at a time, Hz."""
    if scene is None or measured is None or measured.position is None:
        return None
    if not set(scene.joint_names) <= set(measured.names):
        return None
    from flexsim_node import natural_frequencies

    row = measured.position[int(np.argmin(np.abs(measured.series.time - time)))]
    place = [float(row[measured.names.index(name)]) for name in scene.joint_names]
    try:
        found = natural_frequencies(scene, place, locked=True)
    except (ValueError, ArithmeticError):
        return None
    return [float(f) for f in found[:SHOWN_MODES]]


def stress(
    figures: dict[str, Any], count: int, scene: Scene | None, why_not: str, stresses: Stresses | None
) -> Section:
    """Say what the links bore."""
    section = Section("Stress")
    figures["stress"] = None
    if stresses is None:
        section.missing(f"Stress: {why_not if scene is None else 'the bag lacks elastic_layout'}.")
        return section
    try:
        found: list[LinkStress] = stresses.found()
    except ValueError as problem:
        section.missing(f"Stress: {problem}.")
        return section
    if not found:
        section.missing("Stress: the scene has no flexible link.")
        return section
    section.say(
        "Largest equivalent stress (von Mises) of each link's sections: normal stress at the corner where "
        "the axial force and both bendings add up, with the largest shear of torsion and of the transverse "
        "forces (3/2 of its mean, as in a rectangle), as if all met in one point. Elastic, without stress "
        "concentrations."
    )
    if stresses.period:
        section.say(f"From every {count / MOST:.0f}th elastic state.")
    few = [k.name for k in scene.links if scene.modes_of(k) is not None] if scene is not None else []
    if few:
        section.say(
            f"{', '.join(few)}: reduced to a few modes, whose strains miss part of the axial and transverse"
            " forces (tens of percent of a link's own weight) and some of the bending; section_force"
            " sensors do not."
        )
    if any(s.assumed for s in found):
        names = ", ".join(s.link for s in found if s.assumed)
        section.say(f"{names}: given by its constants; taken as the rectangle with the same second moments.")
    figures["stress"] = {
        s.link: {"peak": s.peak, "at": s.at, "from_start": s.where, "axial": s.parts[0],
                 "bending": s.parts[1], "torsion": s.parts[2], "shear": s.parts[3],
                 "assumed_section": s.assumed}
        for s in found
    }  # fmt: skip
    columns = ["link", "peak, MPa", "at, s", "from its start, m"]
    section.table(
        [*columns, "axial, MPa", "bending, MPa", "torsion, MPa", "shear, MPa"],
        [[s.link, MEGAPASCALS * s.peak, s.at, s.where, *(MEGAPASCALS * p for p in s.parts)] for s in found],
    )

    def draw(axes: Any) -> None:
        for n, s in enumerate(found):
            axes.plot(s.place, MEGAPASCALS * s.most, color=pictures.LINES[n % len(pictures.LINES)],
                      label=s.link)  # fmt: skip
        axes.set(xlabel="from the link's start, m", ylabel="largest stress, MPa", ylim=(0.0, None))

    section.picture(pictures.svg(draw, "Largest stress along the links"))
    return section
