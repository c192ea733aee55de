"""How much each element of a robot is stretched, bent and twisted, from its nodes alone.

An element's axis in its link's frame is not in the bag; but the elastic translation of a node is
there in both frames, so the axis is what makes its component along the beam the same in both.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .tube import Skeleton

KINDS = ("axial", "bending", "torsion")
TITLES = {"axial": "Axial strain", "bending": "Bending strain", "torsion": "Torsion strain"}
# Of the singular values that tell an axis: below this part of the largest, nothing moved that way.
SMALLEST = 1e-9


class Strain:
    """Strains of the outermost fibre, mean over each element.

    Parameters
    ----------
    skeleton : Skeleton
    position, rigid_position (K, 3 N), displacement (K, 6 N)
        Some states from which the axes are found.
    """

    def __init__(
        self, skeleton: Skeleton, position: NDArray, rigid_position: NDArray, displacement: NDArray
    ) -> None:
        self.segments = np.array(skeleton.segments, dtype=np.intp).reshape(-1, 2)
        self.outer = skeleton.outer
        length, along = self._along(rigid_position)
        self.length = np.maximum(length.mean(axis=0), 1e-12)
        moved = (position - rigid_position).reshape(len(position), -1, 3)
        local = displacement.reshape(len(position), -1, 6)[:, :, :3]
        self.axis = np.zeros((len(self.segments), 3))
        for chain in skeleton.chains:
            ends = np.unique(self.segments[chain])
            # Each node's translation along the beam, in the base's frame and in the link's.
            wanted = np.einsum("knx,kx->kn", moved[:, ends], along[:, chain[0]]).ravel()
            found = np.linalg.lstsq(local[:, ends].reshape(-1, 3), wanted, rcond=SMALLEST)[0]
            norm = np.linalg.norm(found)
            self.axis[chain] = found / norm if norm > 0.5 else 0.0

    def _along(self, rigid_position: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        nodes = rigid_position.reshape(len(rigid_position), -1, 3)
        way = nodes[:, self.segments[:, 1]] - nodes[:, self.segments[:, 0]]
        length = np.linalg.norm(way, axis=2)
        return length, way / np.maximum(length, 1e-12)[:, :, None]

    def __call__(
        self, position: NDArray, rigid_position: NDArray, displacement: NDArray
    ) -> NDArray[np.float64]:
        """Return axial, bending and torsion strain (K, S, 3) of K states."""
        _, along = self._along(rigid_position)
        moved = (position - rigid_position).reshape(len(position), -1, 3)
        first, second = self.segments.T
        axial = np.einsum("ksx,ksx->ks", moved[:, second] - moved[:, first], along) / self.length
        turned = displacement.reshape(len(position), -1, 6)[:, :, 3:]
        turn = (turned[:, second] - turned[:, first]) / self.length[:, None]
        twist = np.einsum("ksx,sx->ks", turn, self.axis)
        bend = np.linalg.norm(turn - twist[:, :, None] * self.axis, axis=2)
        return np.stack([np.abs(axial), bend * self.outer, np.abs(twist) * self.outer], axis=2)
