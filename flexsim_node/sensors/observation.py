"""What a user sees of a state: where links and nodes are, in the base frame, and how far they are bent."""

from __future__ import annotations

import numpy as np

from ..compiled.kernel import kernel
from ..equations.co_moving import view
from ..equations.kinematics.nodal_motion import place, spatial_row
from ..equations.reduced.link import recover
from ..model.chain import DISPLACEMENT, FIRST, LEVER, PARENT, ROTATION, SPIN
from ..model.reduced.layout import MODES
from ..rotations.section_turn import rotation_vector


@kernel
def observe(chain, work, axes, shown, station, x, position, rigid_position, displacement, pose):
    """Write node positions, those of the rigid links (N, 3) and displacements (N, 6) in link frames.

    shown (L + 1,) says where each link's nodes start in these arrays, station (N,) how far they are along it.
    pose (L, 12) gets each body frame's origin and rotation (row-wise) in the base frame.
    """
    place(chain, work, x)
    observe_as(
        chain.co_moving, chain, work, axes, shown, station, position, rigid_position, displacement, pose
    )


@kernel
def observe_as(co, chain, work, axes, shown, station, position, rigid_position, displacement, pose):
    """observe for either formulation; the other one is not even compiled."""
    if len(co) > 0:
        view.observe(chain, work, axes, position, rigid_position, displacement, pose)
    else:
        observe_erls(chain, work, axes, shown, station, position, rigid_position, displacement, pose)


@kernel
def observe_erls(chain, work, axes, shown, station, position, rigid_position, displacement, pose):
    """observe for frames of the ERLS."""
    link, frame = chain.link, work.frame
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
        for i in range(shown[n], shown[n + 1]):
            shown_displacement(chain.reduction, chain, work, n, i - shown[n], r)
            if chain.setting[SPIN] > 0.0:
                rotation_vector(r[3:6], r[3:6])
            for k in range(3):
                rigid_position[i, k] = p[k] + p[3 + 3 * k] * station[i]
                position[i, k] = rigid_position[i, k]
                displacement[i, k] = 0.0
                displacement[i, 3 + k] = 0.0
                for m in range(3):
                    position[i, k] += p[3 + 3 * k + m] * r[m]
                    displacement[i, k] += axes[n, k, m] * r[m]
                    displacement[i, 3 + k] += axes[n, k, m] * r[3 + m]


@kernel
def shown_displacement(reduction, chain, work, n, i, out):
    """Displacement (6,) of node i of link n, which is recovered from the modes where the link is reduced."""
    planar = len(chain.dofs) == 3
    if len(reduction) == 0 or chain.reduced[n, MODES] < 0:
        spatial_row(work.node[DISPLACEMENT, chain.link[n, FIRST] + i], planar, out)
    else:
        recover(chain, work, n, i, DISPLACEMENT, work.row[1])
        spatial_row(work.row[1], planar, out)


class Observation:
    """Buffers of one view of the robot, refreshed by `look`."""

    def __init__(self, model) -> None:
        nodes, links = len(model.node_link), len(model.chain.link)
        self.model = model
        self.position = np.zeros((nodes, 3))
        self.rigid_position = np.zeros((nodes, 3))
        self.displacement = np.zeros((nodes, 6))
        self.pose = np.zeros((links, 12))
        self.ends = model.first_node[1:] - 1

    def look(self, work, x: np.ndarray) -> None:
        """Fill the buffers from the unknowns x."""
        observe(
            self.model.chain,
            work,
            self.model.axes,
            self.model.first_node,
            self.model.station,
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
