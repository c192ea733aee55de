"""The skin that is drawn lies around the curve through the nodes."""

from __future__ import annotations

import numpy as np
import pytest
from flexsim.rerun_view.tube import SIDES, Skeleton, Tube, curve_weights

# Two links of three nodes; they share a place, not a node.
ARM = Skeleton(
    node_names=("a/0", "a/1", "a/2", "b/0", "b/1", "b/2"),
    segments=((0, 1), (1, 2), (3, 4), (4, 5)),
    radius=np.array([0.02, 0.02, 0.01, 0.01]),
)
NODES = np.array([[[0, 0, 0], [0, 0.1, 1], [0, 0, 2], [0, 0, 2], [1, 0, 2], [2, 0, 2]]], float)


@pytest.mark.parametrize("nodes", [2, 3, 4, 5, 20])
def test_curve_goes_through_the_nodes(nodes: int) -> None:
    """At a node the curve is the node, and a straight link stays straight and even."""
    weights = curve_weights(nodes)
    fine = (len(weights) - 1) // (nodes - 1)
    np.testing.assert_allclose(weights[::fine], np.eye(nodes), atol=1e-12)
    even = weights @ np.linspace(0.0, 1.0, nodes)
    np.testing.assert_allclose(even, np.linspace(0.0, 1.0, len(weights)), atol=1e-12)


def test_skin_is_around_the_curve() -> None:
    """Every vertex is one radius from its curve point, straight across, with a unit normal."""
    tube = Tube(ARM)
    centre = tube.centre(NODES)
    vertices, normals = tube.vertices(centre)
    around = vertices.reshape(1, -1, SIDES, 3) - centre[:, :, None]
    np.testing.assert_allclose(np.linalg.norm(around, axis=3)[0], tube.radii[:, None] + np.zeros(8),
                               rtol=1e-5)  # fmt: skip
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0, rtol=1e-5)
    assert tube.triangles.max() == vertices.shape[1] - 1
    # The second link is straight along x, so nothing of its skin moves along x.
    second = around[0, tube.starts[1] :]
    np.testing.assert_allclose(second[:, :, 0], 0.0, atol=1e-6)


def test_links_that_share_a_joint_node() -> None:
    """Links are told apart also where they share the node of their joint."""
    shared = Skeleton(("a/0", "a/1", "b/1", "b/2"), ((0, 1), (1, 2), (2, 3)), np.full(3, 0.01))
    assert shared.chains == [[0], [1, 2]]
    assert ARM.chains == [[0, 1], [2, 3]]
    assert ARM.rigid().segments == ((0, 2), (3, 5))
