"""From a scene to the immutable arrays of its equations; effects that are off leave no trace here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scene.load import Scene, SceneError
from .chain import Chain
from .dofs import is_planar
from .erls import erls_condition
from .tables import Tables

CONDITION_LIMIT = 1e8  # of J_0, beyond which the ERLS is not defined by the zeroed dofs


@dataclass(frozen=True)
class Model:
    """A robot ready to be simulated.

    Attributes
    ----------
    chain : the compiled kernels' arrays
    joints : m, number of joint coordinates, the first unknowns
    unknowns : n, joint coordinates and free elastic dofs
    planar : three dofs a node instead of six
    axes : (L, 3, 3), columns are the beam axes in the link's frame
    node_link : (N,) link of every node; node_names : (N,)
    first_node : (L + 1,) where each link's nodes start among these; station : (N,) their distance along it, m
    joint_links : (m,) link at whose start each joint sits
    actuated : (m,) bool, which joints have a motor
    turn : (m,) unknown of the joint's own elastic rotation, or -1 (joint angle = q + that)
    motor : (m,) unknown of the motor's angle where a spring stands between it and the link, or -1
    zeroed : for each link the zeroed dofs, (node, dof) to a direction (6,) in beam axes
    limits : (7, 2) where the validity watch warns and stops
    driven : names of the joints whose motion is prescribed
    """

    scene: Scene
    chain: Chain
    joints: int
    unknowns: int
    planar: bool
    axes: np.ndarray
    node_link: np.ndarray
    node_names: tuple[str, ...]
    first_node: np.ndarray
    station: np.ndarray
    joint_links: np.ndarray
    turn: np.ndarray
    actuated: np.ndarray
    motor: np.ndarray
    zeroed: list[dict[tuple[int, int], np.ndarray]]
    limits: np.ndarray
    driven: tuple[str, ...] = ()

    @property
    def swings(self) -> bool:
        """Whether joint coordinates are other than the motors' angles, so that J_0 changes."""
        return any(node > 0 for directions in self.zeroed for node, _ in directions)

    @property
    def turned(self) -> np.ndarray:
        """(m,) unknowns that the motors turn: joint coordinates, or the angles of motors behind springs."""
        return np.where(self.motor >= 0, self.motor, np.arange(self.joints))

    def shown(self, y: np.ndarray) -> np.ndarray:
        """(m,) what the motors' encoders show of the unknowns y (n,), or of their rates.

        That is the motor's own angle where a spring follows, else the joint's, with its elastic rotation.
        """
        own = np.flatnonzero((self.turn >= 0) & (self.motor < 0))
        found = y[self.turned]
        found[own] += y[self.turn[own]]
        return found


def build_model(scene: Scene, planar: bool | None = None, driven: tuple[str, ...] = ()) -> Model:
    """Build the arrays of a scene's equations.

    Parameters
    ----------
    planar : three dofs a node where True, six where False; found from the scene where None
    driven : names of the joints whose motion is prescribed

    Raises
    ------
    SceneError
        where the zeroed dofs don't define the ERLS
    Undecided
        where the scene leaves something to `auto`: choosing takes runs, so it comes first (decide.py)
    """
    if planar is None:
        planar = is_planar(scene)
    tables = Tables(scene, planar, driven)
    chain = tables.chain()
    model = Model(
        scene=scene,
        chain=chain,
        joints=tables.joints,
        unknowns=tables.unknowns,
        planar=planar,
        axes=tables.axes,
        node_link=np.array(tables.node_link),
        node_names=tuple(tables.node_names),
        first_node=np.searchsorted(tables.node_link, range(len(scene.links) + 1)),
        station=np.array(tables.stations),
        joint_links=np.array(tables.joint_links, dtype=np.int64),
        turn=np.array(tables.turns, dtype=np.int64),
        actuated=np.array([joint.actuated for joint in scene.joints]),
        motor=np.array(tables.motors, dtype=np.int64),
        zeroed=tables.zeroed,
        limits=tables.limits,
        driven=driven,
    )
    check_zeroed(model, scene.start("position"))
    return model


def check_zeroed(model: Model, position: np.ndarray) -> None:
    """Raise SceneError where the zeroed dofs don't define the ERLS with the joints at position (m,)."""
    condition = erls_condition(model.chain, model.zeroed, position)
    if not condition < CONDITION_LIMIT:
        raise SceneError(
            f"{model.scene.name}: erls.zeroed: J_0 is singular (condition {condition:.1e}) at the initial"
            " position: the zeroed dofs don't hold every joint; give root, or for each joint a dof that"
            " turns with it"
        )
