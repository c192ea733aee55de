"""`flexsim info`: what is in a bag, and how what it recorded went."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import click

from ..terminal.progress import Progress
from ..terminal.report import print_json, print_table, say

if TYPE_CHECKING:
    from ..bag.qos import Qos
    from ..health.examination import Examination
    from ..health.timing import Timing

# Of one kind, so many are printed; --json has more.
MOST_PRINTED = 8


@click.command()
@click.argument("bag", type=click.Path())
@click.option("--quick", is_flag=True, help="Only what the bag's index says; no message is read.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(bag: str, quick: bool, as_json: bool) -> None:
    """Show what is in a bag, and what was not as it should be while it was recorded.

    BAG is a bag's folder, or one .mcap file. Shown are topics, types, counts, rates, jitter and
    quality of service; and, each with its time, gaps, lost messages, jumps of the clock, missed
    deadlines, and warnings of energy, validity and whatever else /diagnostics told.

    \b
    Example:
      flexsim info run
      flexsim info run --json
    """
    from ..bag import Bag
    from ..bag.description import describe

    opened = Bag(bag)
    found = describe(opened)
    if not quick:
        from ..health.examination import examine

        progress = Progress()
        begun = time.monotonic()
        seen = examine(opened, lambda n: progress.show(f"{n} of {opened.count} messages read"))
        progress.clear()
        found["complete"] = opened.complete
        found["damages"] = [str(damage) for damage in opened.damages]
        for name, timing in seen.timings.items():
            found["topics"][name] |= timing_figures(timing)
        found |= seen.figures() | {"elapsed": round(time.monotonic() - begun, 3)}
        if not as_json:
            print_info(found)
            print_findings(seen)
            return
    if as_json:
        print_json(found)
    else:
        print_info(found)


def timing_figures(timing: Timing) -> dict[str, Any]:
    """Return a topic's timing for --json; times in s since the bag's start."""
    longest = timing.longest
    return {
        "regular": timing.regular,
        "interval": timing.interval,
        "jitter": timing.jitter,
        "longest_interval": None if longest is None else [longest.begin, longest.end],
        "gaps": [[g.begin, g.end, g.messages] for g in timing.gaps if not g.still],
        "stood_still": [[g.begin, g.end] for g in timing.gaps if g.still],
        "lost": timing.lost,
        "losses": [[loss.begin, loss.end, loss.count] for loss in timing.losses],
        "stamped_interval": timing.stamped,
        "missing_stamps": timing.missing,
        "latency": timing.latency,
        "logged_backwards": timing.backwards,
        "clock_jumps": [[j.at, j.before, j.after] for j in timing.jumps],
    }


def print_info(found: dict[str, Any]) -> None:
    """Print the table of a bag's topics."""
    title = (
        f"{found['bag']}: {found['messages']} messages, {found['bytes'] / 1e6:.1f} MB, "
        f"{found['duration']:.1f} s"
    )
    if found["storage"] != ["mcap"] or found["compression"]:
        by = f", compressed by {found['compression']}" if found["compression"] else ""
        title += f", {' and '.join(found['storage']) or 'no file'}{by}"
    if found["start"]:
        title += f" from {found['start']}"
    read = "elapsed" in found
    columns = ["topic", "type", "messages", "rate, Hz"]
    columns += ["jitter, ms", "longest, ms", "gaps", "lost"] if read else []
    rows = []
    for name, t in found["topics"].items():
        row = [
            name,
            ", ".join(t["types"]) or t["type"],
            t["messages"],
            "" if t["rate"] is None else f"{t['rate']:.1f}",
        ]
        if read and "jitter" in t:
            longest = t["longest_interval"]
            row += [
                f"{1e3 * t['jitter']:.2f}" if t["regular"] else "",
                f"{1e3 * (longest[1] - longest[0]):.1f}" if t["regular"] else "",
                len(t["gaps"]) if t["regular"] else "",
                "" if t["lost"] is None else t["lost"],
            ]
        elif read:
            row += ["", "", "", ""]
        rows.append([*row, "; ".join(dict.fromkeys(in_words(p) for p in t["qos"]))])
    print_table(title, [*columns, "quality of service"], rows)
    for node, scene in found["scenes"].items():
        told = (
            scene.get("why_not")
            or f"{scene['name']}, {scene['hash'][:15]}, flexsim {scene['versions']['flexsim']}"
        )
        say(f"scene of {node}: {told}")
    for name, t in found["topics"].items():
        if t["not_decoded"]:
            say(f"not decoded: {t['not_decoded']}")
        elif len(t["types"]) > 1:
            say(f"{name} has {len(t['types'])} types; each message is read by its own")
    for name in found["not_read"]:
        say(f"not read: {name}, which metadata.yaml does not list")
    if not found["complete"]:
        click.echo("This bag is damaged, lacks a file or has no end; what is shown could be read.", err=True)
        for damage in found.get("damages", [])[:MOST_PRINTED]:
            say(f"  {damage}", err=True)
        say(f"flexsim recover {found['bag']} makes whole what can be read.", err=True)


def print_findings(seen: Examination) -> None:
    """Print what was not as it should be, each with when."""
    rows: list[list[str]] = []
    for kind, findings in seen.findings().items():
        for f in findings[:MOST_PRINTED]:
            when = f"{f.begin:.3f}" if f.end is None else f"{f.begin:.3f} to {f.end:.3f}"
            rows.append([when, kind, f.what])
        if len(findings) > MOST_PRINTED:
            rows.append(["", kind, f"and {len(findings) - MOST_PRINTED} more; --json lists them"])
    if not seen.timings or not any(t.count for t in seen.timings.values()):
        click.echo("It holds no messages.")
    elif rows:
        print_table("What was not as it should be", ["when, s", "kind", "what"], rows)
    else:
        click.echo("Nothing that was recorded went wrong: no gaps, no jumps, no warnings.")


def in_words(profile: Qos) -> str:
    """Say a profile in the words that matter."""
    depth = f", depth {profile['depth']}" if profile.get("depth") else ""
    return f"{profile.get('reliability')}, {profile.get('durability')}{depth}"
