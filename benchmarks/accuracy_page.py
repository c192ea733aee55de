"""Make docs/accuracy.md and its diagrams from the studies kept in docs/accuracy/*.json.

    python benchmarks/accuracy_page.py            # from what is kept
    python benchmarks/accuracy_page.py --study    # run the studies again first (an hour or more)

The studies are those of `flexsim accuracy` (STUDIES below); the peers' figures are those of
`python benchmarks/peers_robot.py --json docs/accuracy/peers_robot.json` and of peers_door.py.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from flexsim.study.choice import Cost, duration_said, formulations_said, frontier
from flexsim.study.diagram import draw
from flexsim.study.point import Measure, Outcome
from flexsim.study.robot_grid import REAL_TIME
from peers_robot import matched

ROOT = Path(__file__).resolve().parents[1]
KEPT, IMAGES, PAGE = ROOT / "docs" / "accuracy", ROOT / "docs" / "images", ROOT / "docs" / "accuracy.md"
STUDIES = {
    "simple_pendulum": ["config/simple_pendulum.yaml", "--tolerance", "0.5mm"],
    "planar_double_pendulum": ["config/planar_double_pendulum.yaml", "--tolerance", "0.5mm"],
    "spatial_double_pendulum": [
        *(
            "config/spatial_double_pendulum.yaml",
            "--set",
            "gravity=[0,0,0]",
            "--set",
            "initial.velocity=[0,0]",
        ),
        *("--sine", "joint_1=3@2", "--sine", "joint_2=2@3", "--tolerance", "0.5mm"),
    ],
    "anthropomorphic": ["config/anthropomorphic.yaml", "--sine", "joint_1=5@1", "--tolerance", "0.5mm"],
    **{
        robot: [f"config/{robot}.yaml", "-d", "0.3", "--sine", "joint_1=5@1", "--tolerance", "0.5mm"]
        for robot in ("anthropomorphic_spherical_wrist", "dlr_spherical_wrist")
    },
    "four_bar": ["config/four_bar.yaml", "-d", "0.2", "--sine", "crank_joint=0.02@5", "--tolerance", "0.5mm"],
    "thesis_door": [
        "config/thesis_door_calibrated.yaml",
        "--set",
        "solver.model=column_rim",
        "--tolerance",
        "1K",
    ],
}
CLEAR = 10.0
BESIDE = 1e-3
"""s: the step at which formulations and reductions stand side by side."""

HEAD = (KEPT / "head.md").read_text(encoding="utf-8")

LEARNED = """## What was learned, and the defaults that follow

- **`rosenbrock_w` is the default.** Its second order shows from 4 ms down wherever the motion is smooth
  (tables above). On the driven robot it is three times as exact at the same step for 1.8 times the time:
  even at equal accuracy. On the released robot it is ahead, on the four-bar behind by little.
- **Order is lost after a start that excites stiff modes**, and with `generalized_alpha` first (a beam let go
  from its undeformed shape): modes with more than one radian a step are carried on with a wrong phase and die
  slowly, so the error hardly falls until the step resolves them. The four-bar begins at full speed with
  straight strips: down to 0.5 ms neither method shows its order. From a smooth start both show 2.0. The
  spatial double pendulum is driven from rest here, for the same reason: let go at 2 rad/s with straight
  links, the two methods are 0.05 mm apart with sixteen elements a link even at 31 µs, and a reference that
  they do not agree on is none.
- **Two cubic elements a link are the default.** They leave 0.001 mm on the driven robot (one: 0.008 mm), the
  size of the error of 0.25 ms steps. Thin strips at speed ask for more: the four-bar's rocker is 4 mm off
  with one element, 0.4 mm with two, and the step decides from four on, which its scene has. With two and
  1 ms it is 0.2 mm off only because the errors of mesh and step happen to oppose each other.
- **Reduction pays where a mesh is finer than the motion needs**: eight elements and six modes a link take
  a third of the time of the whole eight in space and three fifths in the plane ([measured](robot.md) later
  than the tables above). Two whole elements are cheaper still: no default.
- **Below the distance of the formulations the step is not what limits.** `erls` and `co_moving` are 0.02 mm
  apart on the driven robot of steel; steps finer than 1 ms follow the equations there more exactly than the
  robot. A step of either costs about the same; `erls` stays the default because
  reduction needs it.
- **Explicit methods are no choice here.** Rayleigh's beta makes the fastest mode so stiff that Runge-Kutta
  fails at 5 µs and DOP853 would take ten minutes and more for half a second; Radau serves as a check only.
- **A door's unexposed face asks for bricks, its exposed face for steps.** Any second-order march, even
  with steps of a minute, leaves only the error of the mesh on the unexposed face, while the exposed one
  is 2.3 K off; implicit Euler is 8 and 29 K off. The adaptive march serves both and stays the default.
  Twice the bricks through the wool takes 0.5 K to 0.2 K; the column knows nothing of the rim.
"""


def load(path: Path) -> dict[str, Any]:
    """A kept study."""
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def outcomes_of(study: dict[str, Any]) -> list[Outcome]:
    """Its points."""
    fields = Outcome.__dataclass_fields__
    return [Outcome(**{k: v for k, v in p.items() if k in fields}) for p in study["points"]]


def section(name: str, study: dict[str, Any]) -> list[str]:
    """A study's part of the page, and its diagram."""
    outcomes = outcomes_of(study)
    measures = [Measure(n, m["label"], m["unit"], m["scale"]) for n, m in study["measures"].items()]
    main, cost = measures[0], Cost(study["rate"])
    own = study["reference"]["error"]
    best = frontier(outcomes, main.name, CLEAR * own[main.name])
    image = IMAGES / f"accuracy_{name}.png"
    budget = 0.2 / cost.rate if cost.rate else None
    title = f"{study['name']}: {main.label}"
    draw(image, title, outcomes, best, main, CLEAR * own[main.name], cost, budget)
    drive = ", ".join(f"{j} driven by {a:g} sin(2 pi {f:g} t) N m" for j, (a, f) in study["drive"].items())
    shown = [m for m in measures if any(o.errors.get(m.name) is not None for o in outcomes)]
    lines = [
        f"## {study['name']}",
        "",
        f"`flexsim accuracy {' '.join(STUDIES[name])}`",
        "",
        f"{study['duration']:g} s{', ' + drive if drive else ''}. Reference: {study['reference']['how']}."
        " Its own error: "
        + ", ".join(f"{m.label} {m.show(own[m.name])}" for m in shown if m.name in own)
        + ".",
        "",
        f"![error against time](images/{image.name})",
        "",
        f"**{study['sentence']}**",
        "",
        "Those that nothing beats in both time and error:",
        "",
        "| method | step | time | spread | " + " | ".join(m.label for m in shown) + " |",
        "|---" * (4 + len(shown)) + "|",
    ]
    for o in best:
        step = duration_said(o.step) if o.step else f"tolerance {o.size:g}"
        cells = [o.curve, step, f"{o.median:.3g} s", f"±{o.spread:.0%}"]
        lines.append("| " + " | ".join(cells + [m.show(o.errors.get(m.name)) for m in shown]) + " |")
    said = formulations_said(study.get("formulation"), study.get("formulations", {}), main)
    lines += ["", *said] if said else []
    at_once = [o for o in outcomes if o.ok and o.step is not None and abs(o.step / BESIDE - 1.0) < 1e-6]
    beside = [o for o in at_once if {"formulation", "reduction"} & set(o.overrides)]
    if beside:
        mine = {f"{REAL_TIME[0]}, {n} elements a link" for n in (2, 4, 8)}
        beside = [o for o in at_once if o.curve in mine] + beside
        lines += ["", "Formulations and reduced links, steps of 1 ms:", ""]
        lines += ["| method | time | spread | " + " | ".join(m.label for m in shown) + " |"]
        lines += ["|---" * (3 + len(shown)) + "|"]
        for o in beside:
            cells = [o.curve, f"{o.median:.3g} s", f"±{o.spread:.0%}"]
            lines.append("| " + " | ".join(cells + [m.show(o.errors.get(m.name)) for m in shown]) + " |")
    effects = [o for o in outcomes if o.effect and o.ok]
    if effects:
        lines += [
            "",
            "What each effect changes:",
            "",
            "| effect | " + " | ".join(m.label for m in shown) + " |",
        ]
        lines.append("|---" * (1 + len(shown)) + "|")
        lines += [
            f"| {o.curve} | " + " | ".join(m.show(o.errors.get(m.name)) for m in shown) + " |"
            for o in effects
        ]
    if study["orders"]:
        lines += ["", "| observed order, from each step to the next | |", "|---|---|"]
        lines += [f"| {curve} | {', '.join(map(str, o))} |" for curve, o in study["orders"].items()]
    failed = [o for o in outcomes if not o.ok]
    if failed:
        lines += ["", "Without a result: " + "; ".join(f"{o.point} ({o.status})" for o in failed) + "."]
    machine = ", ".join(f"{k} {v}" for k, v in study["machine"].items())
    return [*lines, "", f"Times: seconds for a simulated second. {machine}." if cost.rate
            else f"Times: processor seconds for the test. {machine}.", ""]  # fmt: skip


def peers(found: dict[str, Any]) -> list[str]:
    """The part about other programs."""
    lines = [
        "## Beside other programs",
        "",
        "`python benchmarks/peers_robot.py`, each robot in one run; time at the smallest tip error that both"
        " reach (at least 0.01 mm, to which the reference motions are converged), and the ratio at the error"
        " that suits the peer best:",
        "",
        "| problem | peer | error | peer | flexsim | ratio | least ratio |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, problem in found["problems"].items():
        for m in matched(problem["rows"]):
            said = [
                f"{r['method']}, {r['elements']}, {r['step'] * 1e3:g} ms: {r['seconds']:.3g} s per s"
                for r in (m["theirs"], m["ours"])
            ]
            cells = [
                name,
                m["peer"],
                f"{m['error'] * 1e3:.2g} mm",
                *said,
                *(f"{m[r]:.0f}" if m[r] >= 10.0 else f"{m[r]:.1f}" for r in ("ratio", "least")),
            ]
            lines.append("| " + " | ".join(cells) + " |")
    lines += [
        "",
        "Processor time of the steps, undamped, all tools in turns; peers in their own compiled loops,"
        " flexsim with a call from Python for each step. Exudyn with modified Newton iterations and its own"
        " dense solver, the fastest of six combinations on the falling robot; its floating frames hold linear"
        " beams as modes, the tip's static ones and none, one or three with the tip held (the number is that"
        " of all modes of a link), and no smaller step or further mode makes them more exact than they are"
        " here. MuJoCo's links are chains of"
        " rigid pieces with 2 to 8 springs, cut in two ways: where equal beams have their middles, or into"
        " equal pieces as its own cable is. The better of all these stands above: with as many springs, equal"
        " pieces come apart at the same step or a smaller one than half pieces at the ends, and with RK4"
        " they are less exact.",
    ]
    versions = ", ".join(f"{k} {v}" for k, v in found["versions"].items())
    return [
        *lines,
        "",
        f"{versions}; {found['machine']['cores']} cores, load {found['machine']['load']:.1f}.",
        "",
    ]


def peers_door(found: dict[str, Any]) -> list[str]:
    """The part about CalculiX."""
    which = "quarter leaf, 20 x 8 x 14 bricks for both" if found["problem"] == "quarter" else "strip"
    lines = [
        f"The thesis' door, an hour, {which}, `python benchmarks/peers_door.py --quarter`; error at five"
        " places against CalculiX on a finer mesh without error of its steps:",
        "",
        "| tool | steps | error | processor time | ratio |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {r['tool']} | {r['steps']} | {r['error']:.2g} K | {r['seconds']:.3g} s | {r['ratio']:.3g} |"
        for r in found["rows"]
    ]
    return [*lines, "", "CalculiX marches with implicit Euler, whose error falls as its step does.", ""]


def main() -> None:
    """Make the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--study", action="store_true", help="run the studies first")
    arguments = parser.parse_args()
    KEPT.mkdir(exist_ok=True)
    if arguments.study:
        for name, words in STUDIES.items():
            folder = ROOT / "build" / f"accuracy_{name}"
            run = "from flexsim.cli import main; main()"
            command = [sys.executable, "-c", run, "accuracy", *words, "-o", str(folder), "--json"]
            subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
            shutil.copy(folder / "accuracy.json", KEPT / f"{name}.json")
    lines = [*HEAD.splitlines(), ""]
    for name in STUDIES:
        if (KEPT / f"{name}.json").exists():
            lines += section(name, load(KEPT / f"{name}.json"))
    beside = sorted(KEPT.glob("peers_robot*.json"))
    if beside:
        together = load(beside[0])
        for more in beside[1:]:
            together["problems"] |= load(more)["problems"]
        lines += peers(together)
    if (KEPT / "peers_door.json").exists():
        lines += peers_door(load(KEPT / "peers_door.json"))
    lines += LEARNED.splitlines()
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()
