"""Make docs/validation.md and its pictures: run every comparison of benchmarks/validation, or those named.

python benchmarks/validation_page.py                       # all (ten minutes), then the page
python benchmarks/validation_page.py epps_chandra quanser  # these again, the others as they are kept
python benchmarks/validation_page.py --page                # only the page, from docs/validation/*.json
"""

from __future__ import annotations

import argparse
import importlib
import json
from pathlib import Path
from types import ModuleType

from matplotlib.figure import Figure
from validation.comparison import FORMULATIONS, Comparison, Row

ROOT = Path(__file__).resolve().parents[1]
KEPT, IMAGES, PAGE = ROOT / "docs" / "validation", ROOT / "docs" / "images", ROOT / "docs" / "validation.md"
COMPARISONS = (
    "epps_chandra",
    "quanser",
    "loaded_beams",
    "rotating_beams",
    "reference_motions",
    "loaded_frames",
    "princeton_beam",
)
HEIGHT = {"quanser": 4.5, "loaded_frames": 5.5}
KINDS = {"measured": "Measured", "closed form": "Closed forms", "program": "Other programs"}

HEAD = """# What the robot was compared with

Made by `python benchmarks/validation_page.py`; a comparison is a file in `benchmarks/validation/`, its
figures are kept in [validation/](validation/). Measurements come first, then closed forms, then programs.
Differences are relative to the reference unless a unit stands beside them. Under each table stands what
keeps the two apart.
"""

ELSEWHERE = """## Held by tests, or on other pages

| with whom | what | where |
|---|---|---|
| Pinocchio | rigid limit: joint angles within 1e-6 rad after a second, holding torques; wrists, prismatic joints, forks | `tests/robot/test_rigid_limit.py` |
| Exudyn, MuJoCo | time at equal error, falling and driven robot | [accuracy](accuracy.md), `benchmarks/peers_robot.py` |
| Exudyn's ANCF cables | slider-crank at 150 rad/s with an elastic rod, 0.03 mm | `tests/robot/test_loops.py` |
| a second derivation of the equations (complex steps of sampled points) | every term of the equations of motion | `tests/robot/test_independent_equations.py`, `test_co_moving_equations.py` |
| frames under dead loads, by shooting | static shapes of large bending | `tests/robot/static_frame.py` |
| CalculiX | the thesis' fire door | [accuracy](accuracy.md), `benchmarks/peers_door.py` |
| scikit-fem | the door's element matrices | `tests/thermal/test_finite_elements.py` |

Measured fire tests are not on this page: the door's own is [door.md](door.md)'s.
"""  # noqa: E501


def module(name: str) -> ModuleType:
    """One comparison's file."""
    return importlib.import_module(f"validation.{name}")


def number(value: float) -> str:
    """Four digits."""
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


def said(row: Row, formulation: str) -> list[str]:
    """A formulation's two cells: value and difference."""
    value, apart = row.found.get(formulation), row.difference(formulation)
    if value is None or apart is None:
        return [row.without, ""]
    if row.absolute:
        return [number(value), f"{apart:+.2g} {row.unit}"]
    return [number(value), f"{100 * apart:+.2f} %"]


def table(comparison: Comparison) -> list[str]:
    """The rows as a table."""
    head = ["quantity", "unit", "reference", *(c for f in FORMULATIONS for c in (f"`{f}`", "off"))]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for row in comparison.rows:
        cells = [row.quantity, row.unit, number(row.reference)]
        lines.append("| " + " | ".join(cells + [c for f in FORMULATIONS for c in said(row, f)]) + " |")
    return lines


def summary(found: dict[str, Comparison]) -> list[str]:
    """One line a comparison."""
    lines = [
        "| comparison | kind | rows | `erls`: mean, largest | `co_moving`: mean, largest |",
        "|---|---|---|---|---|",
    ]
    for comparison in found.values():
        relative = Comparison(**{**vars(comparison), "rows": [r for r in comparison.rows if not r.absolute]})
        anchor = comparison.title.lower().replace(" ", "-").replace("'", "")
        cells = [f"[{comparison.title}](#{anchor})", comparison.kind, str(len(comparison.rows))]
        for formulation in FORMULATIONS:
            mean, most = relative.error(formulation)
            none = sum(r.found.get(formulation) is None for r in relative.rows)
            text = f"{100 * mean:.2g} %, {100 * most:.2g} %" if relative.rows else "see table"
            cells.append(text + (f"; {none} without a result" if none else ""))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def page(found: dict[str, Comparison]) -> str:
    """The whole page."""
    lines = [*HEAD.splitlines(), "", *summary(found), ""]
    for kind, title in KINDS.items():
        lines += [f"## {title}", ""]
        for name, comparison in found.items():
            if comparison.kind != kind:
                continue
            lines += [f"### {comparison.title}", "", comparison.said, ""]
            lines += [f"Reference: {comparison.source}.", ""]
            lines += [f"![{comparison.title}](images/validation_{name}.png)", "", *table(comparison), ""]
            lines += [f"What limits it: {comparison.limits}", ""]
    return "\n".join([*lines, *ELSEWHERE.splitlines()]) + "\n"


def kept() -> dict[str, Comparison]:
    """Comparisons as they are kept, in the page's order."""
    files = {name: KEPT / f"{name}.json" for name in COMPARISONS}
    return {
        name: Comparison.from_json(json.loads(file.read_text(encoding="utf-8")))
        for name, file in files.items()
        if file.exists()
    }


def main() -> None:
    """Run, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="COMPARISON", help=f"some of {', '.join(COMPARISONS)}")
    parser.add_argument("--page", action="store_true", help="run none, only make the page")
    given = parser.parse_args()
    unknown = sorted(set(given.names) - set(COMPARISONS))
    if unknown:
        parser.error(f"{unknown[0]}: no such comparison; give some of {', '.join(COMPARISONS)}")
    KEPT.mkdir(exist_ok=True)
    for name in () if given.page else given.names or COMPARISONS:
        print(name, flush=True)
        made = module(name).compare()
        (KEPT / f"{name}.json").write_text(json.dumps(made.to_json(), indent=1) + "\n", encoding="utf-8")
    found = kept()
    for name, comparison in found.items():
        figure = Figure(figsize=(8, HEIGHT.get(name, 3.6)), layout="constrained")
        module(name).draw(comparison, figure)
        figure.savefig(IMAGES / f"validation_{name}.png", dpi=110)
    PAGE.write_text(page(found), encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()
