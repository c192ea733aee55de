"""How large a door may be, and what it would cost."""

from __future__ import annotations

from .deformation_part import DeformationPart
from .leaf_part import Leaf
from .parts import MeshPart, SolverPart

MOST_NODES = 1_500_000
MOST_SHELL, MOST_BRICKS = 60_000, 40_000
"""Elements of a deformation whose equations are factored: memory grows faster than their number."""
SECONDS_A_NODE, BYTES_A_NODE = 1.5e-4, 900.0
"""Of an hour's march, measured on the quarter door and the whole (docs/door.md); iterations grow besides."""
THICK = {"full": 12, "column_rim": 24, "column": 60}


def too_large(
    leaf: Leaf, solver: SolverPart, mesh: MeshPart, deformation: DeformationPart
) -> tuple[tuple[str, ...], str] | None:
    """Where a scene asks for too much, and the sentence that says so, or None."""
    dimension = solver.dimension
    layers = mesh.layers or tuple(x.bricks(THICK[dimension]) for x in leaf.layers)
    nx, ny = mesh.in_plane
    across = {"full": (nx + 1) * (ny + 1), "column_rim": nx + 1, "column": 1}[dimension]
    nodes = across * (sum(layers) + 1)
    if nodes > MOST_NODES:
        hours = nodes * SECONDS_A_NODE / 3600.0
        return ("mesh",), (
            f"has {nodes} nodes: some {nodes * BYTES_A_NODE / 1e9:.1f} GB, {8e-9 * nodes:.2f} GB more a"
            f" sample, and {hours:.1f} h or longer for an hour of fire; give in_plane and layers with at most"
            f" {MOST_NODES} nodes (the default has 13 000)"
        )
    if deformation.model == "none":
        return None
    ex, ey = deformation.in_plane
    through = deformation.layers or (3,) * len(leaf.layers)
    elements = ex * ey * (sum(through) if deformation.model == "solid" else 1)
    most = MOST_BRICKS if deformation.model == "solid" else MOST_SHELL
    if elements > most:
        # Factoring a plane of n elements takes n^1.5 operations; 2048 take half a second.
        seconds = 0.5 * (elements / 2048) ** 1.5
        return ("deformation",), (
            f"has {elements} elements: {seconds / 60.0:.0f} min or longer for one shape, and the memory of"
            f" their factors; give in_plane and layers with at most {most} elements"
        )
    return None
