"""`flexsim play`: publishes a bag, or drives a robot through it again."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table, say
from ..terminal.robot_option import robot_option
from ..terminal.setting import setting
from ..terminal.stop import Stop, stopped_by_signals

if TYPE_CHECKING:
    from ..bag import Bag
    from ..ros.player import Player

# What the robot did.
ROBOT = ("sensor_msgs/msg/JointState", "flexsim_msgs/msg/ElasticState", "sensor_msgs/msg/PointCloud2")
KEYS = "space: pause, s or right arrow: one message, +/-: faster, slower, q: end"
FASTER = 1.25


@click.command()
@click.argument("bag", type=click.Path())
@click.argument("topics", nargs=-1, metavar="[TOPIC]...")
@click.option("--without", multiple=True, metavar="TOPIC", help="All but this; may be repeated.")
@click.option("-r", "--rate", type=click.FloatRange(1e-3, 1e3), default=1.0, show_default=True,
              help="Recorded seconds a second.")  # fmt: skip
@click.option("--start-offset", type=click.FloatRange(0.0), default=0.0, metavar="SECONDS",
              help="Begin so long after the bag's beginning.")  # fmt: skip
@click.option("-l", "--loop", is_flag=True, help="Begin again at the end, until Ctrl-C.")
@click.option("--start-paused", is_flag=True, help="Wait for the space bar.")
@click.option("--clock", is_flag=False, flag_value=40.0, default=0.0, type=click.FloatRange(0.0, 1e4),
              metavar="[HZ]", help="Publish the recorded time on /clock, at 40 Hz or so often.")  # fmt: skip
@click.option("-m", "--remap", multiple=True, metavar="OLD:=NEW",
              help="Play a topic under another name; may be repeated.")  # fmt: skip
@click.option("--qos-profile-overrides-path", "profiles", type=click.Path(), metavar="FILE.yaml",
              help="Offer these profiles, by topic.")  # fmt: skip
@click.option("--qos", multiple=True, metavar="TOPIC=POLICY:VALUE,...",
              help="Offer this on a topic, e.g. /scan=reliability:best_effort,depth:5.")  # fmt: skip
@click.option("--wait", type=click.FloatRange(0.0), default=0.0, metavar="SECONDS",
              help="Wait so long for each topic to have a subscriber.")  # fmt: skip
@click.option("--lockstep", is_flag=True,
              help="Drive flexsim_node with what drove the recorded robot.")  # fmt: skip
@click.option("--scene", type=click.Path(exists=True, dir_okay=False), metavar="SCENE",
              help="Lock-step: the scene to drive, if not the one in the bag.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE",
              help="Lock-step: change the scene, e.g. solver.step=5e-4; may be repeated.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(), metavar="BAG",
              help="Lock-step: the new bag; else BAG_again.")  # fmt: skip
@robot_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    bag: str,
    topics: tuple[str, ...],
    without: tuple[str, ...],
    rate: float,
    start_offset: float,
    loop: bool,
    start_paused: bool,
    clock: float,
    remap: tuple[str, ...],
    profiles: str | None,
    qos: tuple[str, ...],
    wait: float,
    lockstep: bool,
    scene: str | None,
    settings: tuple[str, ...],
    output: str | None,
    robot: str,
    as_json: bool,
) -> None:
    """Publish a bag as it was recorded, or drive a robot through it again.

    TOPIC is a topic's name, or a pattern such as '/door/*'; without one, all are played. In a
    terminal: space pauses, s or the right arrow steps by a message, + and - change the rate, q
    ends.

    With --lockstep, flexsim_node is started on the bag's scene and gets, period by period, the
    torques that were in force; what it does is recorded and compared. On the same machine the run
    comes out the same to the bit, however busy the machine is.

    \b
    Example:
      flexsim play run
      flexsim play run /flexsim_node/commands --rate 0.5 --loop
      flexsim play run --clock 100 --remap /joint_states:=/recorded/joint_states
      flexsim play run --lockstep -o again
    """
    if not lockstep and (scene or settings or output or robot):
        raise click.UsageError("--scene, --set, --output and --robot belong to --lockstep.")
    shaped = clock or remap or profiles or qos
    if lockstep and (topics or without or loop or start_offset or start_paused or rate != 1.0 or shaped):
        raise click.UsageError("--lockstep drives the whole run: give neither topics nor timing.")
    from ..bag import Bag

    found = Bag(bag, robot)
    if lockstep:
        once_more(found, scene, dict(map(setting, settings)), output, as_json)
        return
    from ..bag.topics import chosen
    from ..ros.player import Timing

    found.needs_messages()
    names = chosen(found, topics, without)
    played = Played(renamed(found, remap), offered(found, profiles, qos), clock)
    timing = Timing(rate, start_offset, loop)
    if start_offset > found.duration:
        raise click.UsageError(f"--start-offset {start_offset:g}: the bag is {found.duration:g} s long")
    publish(found, names, timing, start_paused, wait, as_json, played)


@dataclass(frozen=True)
class Played:
    """Under which names topics are played, with which profiles, and how often the time is told, Hz."""

    names: dict[str, str]
    profiles: dict[str, Any]
    clock: float


def renamed(bag: Bag, remap: tuple[str, ...]) -> dict[str, str]:
    """Read OLD:=NEW; raises BagError for a topic that the bag lacks."""
    found = {}
    for words in remap:
        old, sign, new = words.partition(":=")
        if not (old and sign and new):
            raise click.UsageError(f"--remap {words}: give OLD:=NEW, such as /joint_states:=/recorded")
        old, new = (name if name.startswith("/") or name in bag.topics else f"/{name}" for name in (old, new))
        found[bag.topic(old).name] = new
    return found


def offered(bag: Bag, path: str | None, words: tuple[str, ...]) -> dict[str, Any]:
    """Return what is to be offered instead of what was recorded, by topic."""
    from ..ros.offered import override, read_overrides

    found = read_overrides(Path(path)) if path else {}
    for one in words:
        topic, profile = override(one)
        found[bag.topic(topic).name] = found.get(topic, {}) | profile
    return found


def publish(
    bag: Bag,
    names: list[str],
    timing: Any,
    start_paused: bool,
    wait: float,
    as_json: bool,
    played: Played,
) -> None:
    """Play a bag until it is over."""
    from ..ros.context import tool_node
    from ..ros.player import Player, is_command
    from ..terminal.keys import keys

    with tool_node("flexsim_play") as node, stopped_by_signals() as stopped, keys() as pressed:
        player = Player(
            node, bag, names, played.names, played.profiles, played.clock, lambda what: say(what, err=True)
        )
        for name, why in player.skipped.items():
            say(f"- {name} is not played: {why}", err=True)
        if not player.counts:
            raise click.ClickException(f"{bag.path} has nothing to play")
        if wait and not player.wait_for_listeners([*player.counts], wait, stopped):
            raise click.ClickException(f"not every topic had a subscriber within {wait:g} s")
        beside = player.beside()
        for name, who in beside.items():
            moved = "is obeyed by, or comes also from," if is_command(bag.topic(name)) else "comes also from"
            say(f"Warning: {name} {moved} {', '.join(who)}; --without {name} leaves it out", err=True)
        player.paused = start_paused
        shown = sys.stderr.isatty() and not as_json
        if shown:
            click.echo(KEYS, err=True)
        elif timing.loop and not as_json:
            click.echo(f"playing {bag.path} over and over; Ctrl-C ends", err=True)
        begun = time.monotonic()
        player.play(timing, stopped, lambda: on_tick(player, timing, pressed(), stopped, shown))
        elapsed = time.monotonic() - begun
        player.finish()
        if shown:
            click.echo("\r\x1b[K", err=True, nl=False)
    result = {
        "bag": str(bag.path),
        "messages": sum(player.counts.values()),
        "elapsed": round(elapsed, 3),
        "latest": round(player.late, 6),
        "topics": player.counts,
        "skipped": player.skipped,
        "beside": beside,
        "complete": bag.complete,
    }
    if as_json:
        print_json(result)
    else:
        late = f"at most {1e3 * player.late:.1f} ms late"
        title = f"{bag.path}: {result['messages']} messages in {elapsed:.1f} s, {late}"
        print_table(title, ["topic", "messages"], list(player.counts.items()))


def on_tick(player: Player, timing: Any, pressed: str, stopped: Stop, shown: bool) -> None:
    """Do what keys ask for, and show where we are."""
    for key in pressed.replace("\x1b[C", "s"):
        if key == " ":
            player.paused = not player.paused
        elif key == "s":
            player.paused = True
            player.step_once()
        elif key in "+-":
            player.set_rate(timing, timing.rate * (FASTER if key == "+" else 1.0 / FASTER))
        elif key in "q\x03":
            stopped.asked = True
    if shown:
        at = max(0, player.position - player.bag.start) * 1e-9
        state = "paused" if player.paused else f"×{timing.rate:.3g}"
        click.echo(f"\r\x1b[K{at:8.2f} of {player.bag.duration:.2f} s  {state}", err=True, nl=False)


def robot_topics(bag: Bag) -> tuple[str, ...]:
    """Return the topics that say what the robot did."""
    return tuple(t.name for t in bag.topics.values() if t.type in ROBOT and t.count)


def once_more(
    bag: Bag, scene: str | None, settings: dict[str, Any], output: str | None, as_json: bool
) -> None:
    """Drive a robot through a recorded run, record it, and compare."""
    from ..comparison.bags import compare_bags
    from ..comparison.scenes import scenes
    from ..comparison.table import as_mapping, print_differences
    from ..replay.again import again

    target = Path(output or f"{bag.path.with_suffix('')}_again")
    if target.exists():
        raise click.ClickException(f"{target} exists already; name another bag or remove it")
    shown = sys.stderr.isatty() and not as_json

    def progress(at: float, duration: float) -> None:
        if shown:
            click.echo(f"\r\x1b[K{at:8.2f} of {duration:.2f} s", err=True, nl=False)

    with stopped_by_signals() as stopped:
        done = again(bag, target, Path(scene) if scene else None, settings, stopped, progress)
    if shown:
        click.echo("\r\x1b[K", err=True, nl=False)
    from ..bag import Bag as Reopened

    again_bag = Reopened(target)
    found = compare_bags(bag, again_bag, robot_topics(bag), once=True)
    compared = as_mapping(str(bag.path), str(target), found)
    # It has a state for each tick, of which the first run may have recorded every second one.
    compared["exact"] = found.alike and not found.not_compared
    compared["scenes"] = scenes(bag, again_bag)
    if as_json:
        print_json(done | {"bag": str(bag.path), "output": str(target), "comparison": compared})
    else:
        speed = done["duration"] / max(done["elapsed"], 1e-9)
        click.echo(
            f"{target}: {done['duration']:g} s driven in {done['elapsed']:.1f} s, {speed:.1f} times real time"
        )
        print_differences(compared)
    if done["stopped"]:
        raise click.ClickException(done["stopped"])
