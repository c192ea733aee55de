"""The skin that is drawn lies around the curve through the nodes."""

from __future__ import annotations

import numpy as np
import pytest
from flexsim.rerun_view.spectrum import spectrum
from flexsim.rerun_view.strain import Strain
from flexsim.rerun_view.tube import SIDES, Skeleton, Tube, curve_weights

# Two links of three nodes; they share a place, not a node.
ARM = Skeleton(
    node_names=("a/0", "a/1", "a/2", "b/0", "b/1", "b/2"),
    segments=((0, 1), (1, 2), (3, 4), (4, 5)),
    radius=np.array([0.02, 0.02, 0.01, 0.01]),
    outer=np.array([0.03, 0.03, 0.01, 0.01]),
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
    radius = np.full(3, 0.01)
    shared = Skeleton(("a/0", "a/1", "b/1", "b/2"), ((0, 1), (1, 2), (2, 3)), radius, radius)
    assert shared.chains == [[0], [1, 2]]
    points = Skeleton(("a/eye/0", "a/eye/1", "a/ear/1", "a/1/1"), ((0, 1), (1, 2), (2, 3)), radius, radius)
    assert points.chains == [[0], [1], [2]]  # a point is a link of its own, LINK/POINT
    assert ARM.chains == [[0, 1], [2, 3]]
    assert ARM.rigid().segments == ((0, 2), (3, 5))


def test_rigid_links_are_seen() -> None:
    """A link without a section is drawn thin; a robot without a link of any length draws nothing."""

    def layout(widths: list[float]) -> Skeleton:
        names = [f"l{n}/{i}" for n in range(max(len(widths), 1)) for i in (0, 1)]
        pairs = np.arange(2 * len(widths))
        columns = {"node_names": [names], "segments": [pairs]}
        return Skeleton.from_layout(
            columns | {f"segment_{k}": [np.array(widths)] for k in ("width", "depth")}
        )

    beams = layout([0.02, 0.0, 0.01]).radius
    assert 0.0 < beams[1] < beams[2] < beams[0]
    assert np.all(layout([0.0, 0.0]).radius > 0.0)
    nothing = Tube(layout([]))
    assert nothing.centre(np.zeros((2, 2, 3))).shape == (2, 0, 3) and nothing.triangles.shape == (0, 3)


def test_strains_of_a_stretched_bent_and_twisted_arm() -> None:
    """Each kind of strain is what it was made of, whatever way the arm points and its frames lie."""
    random = np.random.default_rng(1)
    # Axes of the two links in their own frames; the strains of the four elements, each a kind.
    axes = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    stretch, bend, twist = 1e-4, 2e-3, 3e-3
    across = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    displacement = np.zeros((6, 6))
    for link, (first, second) in enumerate(((0.5, 0.5), (1.0, 1.0))):
        nodes = slice(3 * link, 3 * link + 3)
        s = np.array([0.0, first, first + second])
        displacement[nodes, :3] = np.outer(stretch * s, axes[link]) + np.outer(bend * s**2, across[link])
        displacement[nodes, 3:] = np.outer(twist * s, axes[link])
        displacement[nodes, 3:] += np.outer(2.0 * bend * s, np.cross(axes[link], across[link]))
    states = []
    for _ in range(20):
        rigid, moved = np.zeros((6, 3)), np.zeros((6, 3))
        for link, lengths in enumerate(((0.0, 0.5, 1.0), (0.0, 1.0, 2.0))):
            q, _ = np.linalg.qr(random.standard_normal((3, 3)))
            q *= np.sign(np.linalg.det(q))
            nodes = slice(3 * link, 3 * link + 3)
            rigid[nodes] = np.outer(lengths, q @ axes[link])
            moved[nodes] = displacement[nodes, :3] @ q.T
        states.append((rigid + moved, rigid, displacement))
    position, rigid, local = (np.array(x).reshape(20, -1) for x in zip(*states, strict=True))
    strain = Strain(ARM, position, rigid, local)(position, rigid, local)
    assert strain.shape == (20, 4, 3)
    expected = [[stretch, 2.0 * bend * r, twist * r] for r in ARM.outer]
    np.testing.assert_allclose(strain, np.tile(expected, (20, 1, 1)), rtol=1e-6)


def test_spectrum_shows_each_vibration() -> None:
    """Two sines in different directions are two peaks of their heights; the way of the arm is none."""
    random = np.random.default_rng(2)
    time = np.sort(random.uniform(0.0, 4.0, 2000))
    motion = np.zeros((2000, 3))
    motion[:, 0] = 3.0 * np.sin(2 * np.pi * 6.0 * time) + 50.0 + 20.0 * time
    motion[:, 2] = 0.5 * np.sin(2 * np.pi * 21.0 * time)
    frequency, amplitude = spectrum(time, motion)
    for f, a in ((6.0, 3.0), (21.0, 0.5)):
        near = np.abs(frequency - f) < 1.0
        assert frequency[near][amplitude[near].argmax()] == pytest.approx(f, abs=0.26)
        assert amplitude[near].max() == pytest.approx(a, rel=0.1)
    quiet = (np.abs(frequency - 6.0) > 1.5) & (np.abs(frequency - 21.0) > 1.5)
    assert amplitude[quiet].max() < 0.1
