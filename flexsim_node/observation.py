"""What a user sees of a state: where links and nodes are, in the base frame, and how far they are bent."""

from __future__ import annotations

import numpy as np

from . import co_moving_view
from .chain import COUNT, DISPLACEMENT, FIRST, LEVER, PARENT, ROTATION
from .kernel import kernel
from .kinematics import place, spatial_row


@kernel
def observe(chain, work, axes, x, position, rigid_position, displacement, pose):
    """Write node positions, those of the rigid links (N, 3) and displacements (N, 6) in link frames.

    pose (L, 12) gets each body frame's origin and rotation (row-wise) in the base frame.
    """
    place(chain, work, x)
    observe_as(chain.co_moving, chain, work, axes, position, rigid_position, displacement, pose)


@kernel
def observe_as(co, chain, work, axes, position, rigid_position, displacement, pose):
    """observe for either formulation; the other one is not even compiled."""
    if len(co) > 0:
        co_moving_view.observe(chain, work, axes, position, rigid_position, displacement, pose)
    else:
        observe_erls(chain, work, axes, position, rigid_position, displacement, pose)


@kernel
def observe_erls(chain, work, axes, position, rigid_position, displacement, pose):
    """observe for frames of the ERLS."""
    link, frame = chain.link, work.frame
    planar = len(chain.dofs) == 3
    d = work.node[DISPLACEMENT]
    r = work.row[0, 0:6]
    for n in range(link.shape[0]):
        f, parent = frame[n], link[n, PARENT]
        p = pose[n]
        for i in range(3):
            if parent >= 0:
                q = pose[parent]
                p[i] = q[i]
                for k in range(3):
                    p[i] += q[3 + 3 * i + k] * f[LEVER + k]
                for k in range(3):
                    total = 0.0
                    for m in range(3):
                        total += q[3 + 3 * i + m] * f[ROTATION + 3 * m + k]
                    p[3 + 3 * i + k] = total
            else:
                p[i] = f[LEVER + i]
                for k in range(3):
                    p[3 + 3 * i + k] = f[ROTATION + 3 * i + k]
        for i in range(link[n, FIRST], link[n, FIRST] + link[n, COUNT] + 1):
            spatial_row(d[i], planar, r)
            for k in range(3):
                rigid_position[i, k] = p[k] + p[3 + 3 * k] * chain.place[i]
                position[i, k] = rigid_position[i, k]
                displacement[i, k] = 0.0
                displacement[i, 3 + k] = 0.0
                for m in range(3):
                    position[i, k] += p[3 + 3 * k + m] * r[m]
                    displacement[i, k] += axes[n, k, m] * r[m]
                    displacement[i, 3 + k] += axes[n, k, m] * r[3 + m]


class Observation:
    """Buffers of one view of the robot, refreshed by `look`."""

    def __init__(self, model) -> None:
        nodes, links = len(model.node_link), len(model.chain.link)
        self.model = model
        self.position = np.zeros((nodes, 3))
        self.rigid_position = np.zeros((nodes, 3))
        self.displacement = np.zeros((nodes, 6))
        self.pose = np.zeros((links, 12))
        last = model.chain.link[:, FIRST] + model.chain.link[:, COUNT]
        self.ends = np.asarray(last)

    def look(self, work, x: np.ndarray) -> None:
        """Fill the buffers from the unknowns x."""
        observe(
            self.model.chain,
            work,
            self.model.axes,
            x,
            self.position,
            self.rigid_position,
            self.displacement,
            self.pose,
        )

    @property
    def link_end(self) -> np.ndarray:
        """(L, 3) ends of the links, elastic displacement included."""
        return self.position[self.ends]
