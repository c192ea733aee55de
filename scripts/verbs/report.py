"""`flexsim report`: a recorded run on one page, as an engineer would put it into a report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.output_file import OutputFile
from ..terminal.progress import Progress
from ..terminal.report import print_json, print_table
from ..terminal.robot_option import robot_option

if TYPE_CHECKING:
    from ..bag import Bag
    from ..bag_report.page import Section


@click.command()
@click.argument("bag", type=click.Path())
@click.option("-o", "--output", type=OutputFile(".html", ".htm"), metavar="FILE.html",
              help="Where to write; else the bag's name and .html, here.")  # fmt: skip
@click.option("--scene", type=click.Path(), metavar="SCENE.yaml",
              help="The robot's scene, for stresses and frequencies; else the one in the bag.")  # fmt: skip
@robot_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(bag: str, output: str | None, scene: str | None, robot: str, as_json: bool) -> None:
    """Write a report of a recorded run: one HTML file with tables and plots.

    Of a robot: tracking error, torques, tip deflection, spectrum, natural frequencies and damping
    ratios from its ring-downs, peak stress, real-time health. Of a door: curves and verdict. What
    the bag does not hold is said, and the rest is reported.

    \b
    Example:
      flexsim report run
      flexsim report run --scene config/anthropomorphic.yaml -o run.html --json
    """
    from ..bag import Bag

    opened = Bag(bag, robot)
    opened.needs_messages()
    target = Path(output) if output else Path(f"{opened.path.resolve().stem}.html")
    if scene is not None and not Path(scene).is_file():
        raise click.ClickException(f"{scene} does not exist; give a scene's YAML file")
    progress = Progress()
    found, sections = look(opened, None if scene is None else Path(scene), progress)
    progress.clear()

    from ..bag_report.page import page

    about = f"{found['duration']:.1f} s, recorded from {found['start']}; {found['messages']} messages"
    target.write_text(page(f"{opened.path.resolve().name}", about, sections), encoding="utf-8")
    found["report"] = str(target)
    found["missing"] = [words for section in sections for words in section.gaps]
    if as_json:
        print_json(found)
    else:
        print_summary(found)


def look(bag: Bag, scene: Path | None, progress: Progress) -> tuple[dict[str, Any], list[Section]]:
    """Return figures and sections of all that a bag holds."""
    from ..bag.description import describe
    from ..bag_report import door, robot
    from ..bag_report.health import health_part
    from ..bag_report.model import scene_of
    from ..bag_report.page import Section
    from ..bag_report.reading import Reading
    from ..health.examination import examine

    told = describe(bag)
    found: dict[str, Any] = {
        name: told[name] for name in ("bag", "start", "duration", "messages", "complete", "scenes")
    }
    found |= {"robot": None, "door": None}
    sections: list[Section] = []
    has_robot, has_door = robot.has_robot(bag), door.has_door(bag)
    model, why_not, stresses = None, "", None
    wanted: dict[str, list[str]] = {}
    if has_robot:
        model, why_not = scene_of(bag, scene)
        stresses = robot.stress_of(bag, model)
        wanted |= robot.fields(bag)
    if has_door:
        wanted |= door.fields(bag)
    reading = Reading(bag, wanted)
    takers = [*reading.takers().items()]
    if stresses is not None:
        takers.append((stresses.topic, stresses.add))
    seen = examine(bag, lambda n: progress.show(f"{n} of {bag.count} messages read"), takers)
    if has_robot:
        progress.show("the robot's motion")
        part = robot.robot_part(reading, model, why_not, stresses)
        sections += part.sections
        found["robot"] = {"scene": None if model is None else model.name} | part.figures
    if has_door:
        progress.show("the door's curves")
        parts, figures = door.door_part(reading)
        sections += parts
        found["door"] = figures
    if not sections:
        nothing = Section("Robot and door")
        nothing.missing("Motion and fire: the bag holds neither joint states, elastic states nor a door.")
        sections.append(nothing)
    health, figures = health_part(bag, seen)
    sections.append(health)
    found["health"] = figures
    found["complete"] = bag.complete
    if not bag.complete:
        health.missing("This bag is damaged or has no end; reported is what could be read.")
    return found, sections


def print_summary(found: dict[str, Any]) -> None:
    """Print the main figures."""
    rows: list[list[str]] = []
    robot, door, health = found["robot"], found["door"], found["health"]
    if robot:
        if robot["tracking"]:
            worst = max(robot["tracking"]["joints"].items(), key=lambda e: e[1]["largest"])
            rows.append(["largest tracking error", f"{1e3 * worst[1]['largest']:.3g} mrad or mm, {worst[0]}"])
        if robot.get("deflection"):
            off = robot["deflection"]
            rows.append(
                ["tip deflection", f"rms {1e3 * off['rms']:.3g} mm, largest {1e3 * off['largest']:.3g} mm"]
            )
        for decay in (robot.get("vibration") or {}).get("ring_downs", [])[:1]:
            for mode in decay["modes"][:3]:
                spread = f" ± {100 * mode['spread']:.2g}"
                rows.append(
                    ["mode", f"{mode['frequency']:.3f} Hz, {100 * mode['damping_ratio']:.3g}{spread} %"]
                )
        for link, s in (robot.get("stress") or {}).items():
            rows.append(["peak stress", f"{link}: {1e-6 * s['peak']:.3g} MPa at {s['at']:.3f} s"])
    if door and door["verdict"]:
        rows.append(["verdict", door["verdict"]])
    rows.append(["deadlines missed", str(health["overruns"])])
    print_table(f"{found['bag']}: {found['report']}", ["what", "figure"], rows)
    for words in found["missing"]:
        click.echo(f"missing: {words}")
