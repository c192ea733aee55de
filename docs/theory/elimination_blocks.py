"""Draw docs/images/elimination_blocks.svg, the matrix of config/anthropomorphic.yaml without and with frames.

Left the matrix M over the unknowns, as the kernels have it.  Right the pattern of the same robot with each
frame's acceleration A as unknowns of their own, in the order of elimination (elimination.md, E2).
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

from flexsim_node import load_scene
from flexsim_node.equations.dynamics.tangent import mass_matrix
from flexsim_node.model.model import build_model

ROOT = Path(__file__).parents[2]
SIDE = 320.0
COLOURS = {"node": "#2f6f9f", "frame": "#c8642d", "joint": "#4d8a4f"}


def blocks(links: int, elements: int) -> tuple[list[str], list[tuple[int, int, str]]]:
    """Names of the blocks from the tip to the base, and which pairs are coupled, with a kind each."""
    names = [
        name
        for n in range(links, 0, -1)
        for name in (*(f"u{n}{i}" for i in range(elements, 0, -1)), f"A{n}", f"q{n}")
    ]
    place = {name: k for k, name in enumerate(names)}
    pairs = []
    for n in range(1, links + 1):
        # a link's first node is its parent's last one, or the base
        nodes = [f"u{n}{i}" for i in range(1, elements + 1)]
        if n > 1:
            nodes.insert(0, f"u{n - 1}{elements}")
        pairs += [(node, node, "node") for node in nodes]
        pairs += [(one, two, "node") for one, two in pairwise(nodes)]
        pairs += [(node, f"A{n}", "frame") for node in nodes] + [(f"A{n}", f"A{n}", "frame")]
        pairs += [(f"A{n}", f"q{n}", "joint"), (f"q{n}", f"q{n}", "joint")]
        if n > 1:
            pairs += [(f"A{n}", f"A{n - 1}", "frame"), (f"u{n - 1}{elements}", f"q{n}", "joint")]
    return names, [(place[a], place[b], kind) for a, b, kind in pairs]


def squares(cells: list[tuple[int, int, str]], count: int, left: float) -> list[str]:
    """SVG squares of (row, column, colour) in a square of `count` cells a side, both triangles."""
    size = SIDE / count
    return [
        f'<rect x="{left + c * size:.2f}" y="{40 + r * size:.2f}" width="{size - 0.6:.2f}"'
        f' height="{size - 0.6:.2f}" fill="{colour}"/>'
        for i, k, colour in cells
        for r, c in {(i, k), (k, i)}
    ]


def picture() -> str:
    """The SVG."""
    scene = load_scene(ROOT / "config" / "anthropomorphic.yaml")
    model = build_model(scene)
    mass = mass_matrix(model, np.concatenate([[0.3, 0.6, -0.8], np.full(model.unknowns - 3, 1e-3)]))
    dense = [(i, k, "#6b6f76") for i, k in np.argwhere(np.abs(mass) > 1e-12 * np.abs(mass).max())]
    assert scene.links[0].beam is not None
    names, pairs = blocks(len(scene.links), scene.links[0].beam.elements)
    size = SIDE / len(names)
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 740 400" font-family="sans-serif"'
        ' font-size="13">',
        '<rect width="740" height="400" fill="white"/>',
        f'<text x="20" y="28">M over the {model.unknowns} unknowns</text>',
        '<text x="390" y="28">with the accelerations A of frames, tip to base</text>',
        *squares(dense, model.unknowns, 20.0),
        *squares([(i, k, COLOURS[kind]) for i, k, kind in pairs], len(names), 390.0),
        *(
            f'<text x="{390 + (k + 0.5) * size:.1f}" y="{376 if k % 2 else 388}" font-size="10"'
            f' text-anchor="middle">{name}</text>'
            for k, name in enumerate(names)
        ),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images" / "elimination_blocks.svg"
    out.write_text(picture())
