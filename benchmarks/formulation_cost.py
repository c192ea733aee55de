"""What a step in co-moving frames costs beside one of the ERLS, by what a scene is made of.

    python benchmarks/formulation_cost.py [--quick] [--json]

The steps are taken in turns in one process, so that what else the machine does meets both alike; each
figure is the median ratio with half of its 95 % interval.  `cheaper_co_moving` (in
flexsim_node/analysis/formulations.py) follows them: up to so many elements a link
co-moving frames are clearly the cheaper ones.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flexsim_node import Scene, load_scene
from flexsim_node.analysis.step_cost import step_costs
from flexsim_node.scene.variants import in_formulation

CONFIG = Path(__file__).parents[1] / "config"
ELEMENTS = (1, 2, 4, 8)
METHODS = ("rosenbrock_w", "generalized_alpha", "runge_kutta_4")
ROUNDS = 40


def chain(links: int, spatial: bool, elements: int, **keys: Any) -> Scene:
    """A chain of equal steel links, driven by weight askew."""
    beam = {"width": 0.02, "depth": 0.02, "density": 7800.0, "youngs_modulus": 2e11, "elements": elements}
    dh = {"a": 0.2, "alpha": 1.5707963267948966 if spatial else 0.0}
    joint = {"viscous_friction": 5.0}
    links_ = [{"name": f"link_{k}", "dh": dh, "beam": beam, "joint": joint} for k in range(links)]
    return load_scene({
        "model": "robot", "name": f"chain_{links}", "gravity": [1.0, -1.0, -0.5 if spatial else 0.0],
        "links": links_, **{"damping": {"beta": 1e-4}, **keys},
    })  # fmt: skip


def mechanism(name: str, elements: int) -> Scene:
    """A shipped mechanism with so many elements in every link that bends."""
    scene = load_scene(CONFIG / f"{name}.yaml")
    bends = [k for k, link in enumerate(scene.links) if link.beam is not None and link.flexible]
    return load_scene(CONFIG / f"{name}.yaml", {f"links.{k}.beam.elements": elements for k in bends})


def scenes(quick: bool) -> Iterator[tuple[str, int, dict[str, Scene]]]:
    """(what it is, elements a link, the scene in each formulation)."""
    for elements in ELEMENTS[:2] if quick else ELEMENTS:
        for method in METHODS[:1] if quick else METHODS:
            # an explicit method needs short steps here; the cost of one does not depend on its length
            solver = {"method": method, "step": 2e-7 if method == "runge_kutta_4" else 1e-3}
            for links in (3,) if quick else (1, 3, 6):
                for spatial in (False,) if quick else (False, True):
                    for zeroed in ("chord", "root"):
                        scene = chain(links, spatial, elements, solver=solver, erls={"zeroed": zeroed})
                        what = f"{links} links in {'space' if spatial else 'the plane'}, {method}, {zeroed}"
                        yield what, elements, both(scene)
                        if method == METHODS[0] and not spatial and not quick:
                            scene = chain(
                                links, False, elements, solver=solver, erls={"zeroed": zeroed},
                                damping={"alpha": 2.0, "beta": 1e-4},
                            )  # fmt: skip
                            yield f"{what}, alpha", elements, both(scene)
        if not quick:
            for name in ("four_bar", "delta"):
                yield f"{name}, a loop, rosenbrock_w, chord", elements, both(mechanism(name, elements))


def both(scene: Scene) -> dict[str, Scene]:
    """The scene in each formulation."""
    return {name: in_formulation(scene, name) for name in ("erls", "co_moving")}


def figures(quick: bool) -> list[dict[str, Any]]:
    """Every ratio, as objects for programs."""
    found = []
    for what, elements, several in scenes(quick):
        costs = step_costs(several, rounds=5 if quick else ROUNDS)
        moving = costs["co_moving"]
        found.append({
            "scene": what, "elements": elements, "erls_us": 1e6 * costs["erls"].step,
            "ratio": moving.ratio, "spread": moving.spread,
        })  # fmt: skip
        print(f"{what}, {elements}: {moving.ratio:.2f} ± {moving.spread:.2f}", file=sys.stderr, flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few rounds of few scenes")
    parser.add_argument("--json", action="store_true")
    words = parser.parse_args()
    found = figures(words.quick)
    if words.json:
        print(json.dumps(found, indent=1))
        return
    print("| scene | " + " | ".join(f"{n} elements a link" for n in ELEMENTS) + " |")
    print("|---|" + "---|" * len(ELEMENTS))
    for what in dict.fromkeys(row["scene"] for row in found):
        cells = {r["elements"]: f"{r['ratio']:.2f} ± {r['spread']:.2f}" for r in found if r["scene"] == what}
        print(f"| {what} | " + " | ".join(cells.get(n, "") for n in ELEMENTS) + " |")


if __name__ == "__main__":
    main()
