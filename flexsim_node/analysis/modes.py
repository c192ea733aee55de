"""Natural frequencies and mode shapes of a robot, in one configuration or over a grid of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, solve_triangular

from ..elements.beam import AXIAL, BEND_Y, BEND_Z, LENGTH, SHEAR_Y, SHEAR_Z, TORSION, bending_stiffness
from ..elements.element import element_row
from ..equations.dynamics.tangent import (
    damping_matrix,
    differences,
    elastic_stiffness,
    mass_matrix,
    stiffness_matrix,
)
from ..model.chain import workspace
from ..model.model import Model, build_model
from ..motion.assembly import Assembly
from ..motion.rest_shape import check_position, joint_motion, rest_shape, unknowns_at
from ..scene.schema import Erls, Scene
from ..sensors.observation import Observation
from .decide import decided

KINDS = ("axial", "torsion", "bending_y", "bending_z")


@dataclass(frozen=True)
class Modes:
    """Undamped modes of a robot in one configuration; K modes, N nodes, L links.

    Attributes
    ----------
    frequency : (K,) Hz, rising
    shape : (K, N, 3) translations of the nodes in the base frame, m for a modal coordinate of 1 kg^1/2 m
    slope : (K, N, 3) likewise the changes of the sections' normals there
    node_position, node_normal : (N, 3) about which they swing, base frame; m, unit vectors along the beams
    share : (K, L, 4) of the strain energy in each link's extension, torsion, bending about beam y and about
        beam z; what is left to 1 lies in the joints (and with loads in the geometric stiffness)
    link_names : (L,); node_link : (N,) link of every node
    """

    frequency: np.ndarray
    shape: np.ndarray
    slope: np.ndarray
    node_position: np.ndarray
    node_normal: np.ndarray
    share: np.ndarray
    link_names: tuple[str, ...]
    node_link: np.ndarray

    def name(self, mode: int) -> str:
        """What a mode does most: `link_2 bending_z 81 %, link_1 torsion 12 %`, or `rigid`."""
        share = self.share[mode]
        parts = [(value, n, k) for (n, k), value in np.ndenumerate(share) if value >= 0.1]
        if not np.any(share > 0.0):
            return "rigid"
        largest = sorted(parts, reverse=True)[:3]
        words = [f"{self.link_names[n]} {KINDS[k]} {100 * value:.0f} %" for value, n, k in largest]
        joints = 1.0 - float(share.sum())
        if joints >= 0.1:
            words.append(f"joints {100 * joints:.0f} %")
        return ", ".join(words) or "spread over many links"


def natural_frequencies(
    scene: Scene,
    position: np.ndarray | list,
    locked: bool = True,
    loaded: bool = False,
    velocity: np.ndarray | list | None = None,
) -> np.ndarray:
    """Undamped natural frequencies, Hz, in rising order.

    Parameters
    ----------
    position : (m,) joint coordinates, or (K, m) for K configurations; the actuated ones are enough
    locked : joints held; where False they are free, and each gives a frequency of zero.  With loops the
        actuated joints are held or free, the passive ones always follow
    loaded : about the static equilibrium under gravity, with the stiffness of its loads (then free joints
        may swing; what falls over counts as zero), instead of about the undeformed robot

    velocity : (m,) steady rates of the locked joints, rad/s: the frequencies about the steady shape at that
        spin, with gyroscopic forces, softening and stiffening

    Bending, torsion and extension in space count, also where the scene's motion is planar.

    Returns
    -------
    (n,), or (K, n) for K configurations

    Raises
    ------
    ArithmeticError
        where `loaded` and there is no stable equilibrium
    """
    model = spatial_model(scene)
    places = np.asarray(position, dtype=float)
    if velocity is not None:
        rates = check_position(scene, velocity)
        if not locked or scene.loops:
            raise ValueError(f"{scene.name}: a velocity is that of locked joints of open chains")
        if places.ndim == 2:
            return np.array([spinning_frequencies(model, at, rates) for at in places])
        return spinning_frequencies(model, places, rates)
    if places.ndim == 2:
        return np.array([frequencies_at(model, at, locked, loaded) for at in places])
    return frequencies_at(model, places, locked, loaded)


def frequencies_at(model: Model, position: np.ndarray, locked: bool, loaded: bool) -> np.ndarray:
    """Frequencies (n,) in one configuration."""
    mass, stiffness, x = matrices(model, position, loaded)
    if model.scene.loops:
        squared, _ = closed_modes(model, x, mass, stiffness, locked)
        return np.sqrt(squared) / (2.0 * np.pi)
    squared = eigenvalues(mass, stiffness, model.turned, locked, loaded)
    return np.sqrt(squared) / (2.0 * np.pi)


def spinning_frequencies(model: Model, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Frequencies (n,) about the steady shape with the joints at a constant velocity (m,), without losses."""
    x = rest_shape(model, check_position(model.scene, position), velocity)
    v = joint_motion(model, velocity)
    rest = np.setdiff1d(np.arange(model.unknowns), model.turned)
    block = np.ix_(rest, rest)
    gyroscopic = damping_matrix(model, x, v)[block]
    gyroscopic = 0.5 * (gyroscopic - gyroscopic.T)
    mass, stiffness = mass_matrix(model, x)[block], stiffness_matrix(model, x, v)[block]
    # (s^2 M + s G + K) y = 0 in the coordinates of M's square root
    root = np.linalg.cholesky(mass)
    k = solve_triangular(root, solve_triangular(root, stiffness, lower=True).T, lower=True)
    g = solve_triangular(root, solve_triangular(root, gyroscopic, lower=True).T, lower=True).T
    n = len(rest)
    found = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-k, -g]]))
    return np.sort(np.abs(found.imag))[1::2] / (2.0 * np.pi)


def mode_shapes(
    scene: Scene,
    position: np.ndarray | list[float],
    locked: bool = True,
    loaded: bool = False,
    count: int | None = None,
) -> Modes:
    """Mode shapes and where their energy lies, for the frequencies of `natural_frequencies`.

    Parameters
    ----------
    position : (m,) joint coordinates
    count : the lowest so many; all where None
    """
    model = spatial_model(scene)
    mass, stiffness, x = matrices(model, position, loaded)
    if scene.loops:
        squared, vectors = (part[..., :count] for part in closed_modes(model, x, mass, stiffness, locked))
    else:
        held = model.turned
        squared = eigenvalues(mass, stiffness, held, locked, loaded)[:count]
        kept = np.setdiff1d(np.arange(model.unknowns), held if locked else [])
        vectors = np.zeros((model.unknowns, len(squared)))
        if len(squared):
            block = np.ix_(kept, kept)
            vectors[kept] = eigh(stiffness[block], mass[block])[1][:, : len(squared)]
    view, work = Observation(model), workspace(model.chain)

    def seen(at: np.ndarray) -> np.ndarray:
        view.look(work, at)
        return np.hstack([view.position, section_normals(model, view), view.displacement]).ravel()

    rest = seen(x).reshape(-1, 12)
    moved = differences(seen, x, vectors).T.reshape(-1, *rest.shape)
    shape, slope = moved[:, :, :3], moved[:, :, 3:6]
    energy = np.array([strain_energies(model, row) for row in moved[:, :, 6:]])
    energy = energy.reshape(-1, len(scene.links), len(KINDS))
    total = np.maximum(0.5 * squared, energy.sum(axis=(1, 2)))
    elastic = squared > 0.0
    share = np.zeros_like(energy)
    share[elastic] = energy[elastic] / total[elastic, None, None]
    # the node that moves most moves in the positive direction: a shape's sign is not left to chance
    for k in range(len(shape)):
        if shape[k].flat[np.argmax(np.abs(shape[k]))] < 0.0:
            moved[k] *= -1.0
    return Modes(
        np.sqrt(squared) / (2.0 * np.pi),
        shape,
        slope,
        rest[:, :3],
        rest[:, 3:6],
        share,
        tuple(link.name for link in scene.links),
        model.node_link,
    )


def section_normals(model: Model, view: Observation) -> np.ndarray:
    """(N, 3) normals of the sections at the nodes in the base frame, to the first order of their rotation."""
    axes = model.axes[model.node_link]
    frame = view.pose[model.node_link, 3:].reshape(-1, 3, 3)  # of the beam axes
    turned = axes[:, :, 0] + np.cross(view.displacement[:, 3:], axes[:, :, 0])
    return np.einsum("nij,nkj,nk->ni", frame, axes, turned)


def spatial_model(scene: Scene) -> Model:
    """The robot in space, with joint coordinates that are the motors' angles: those are what is locked."""
    return build_model(decided(scene).model_copy(update={"erls": Erls(zeroed="root")}), planar=False)


def matrices(
    model: Model, position: np.ndarray | list[float], loaded: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass and stiffness (n, n), and the unknowns (n,) about which they hold."""
    x = unknowns_at(model, check_position(model.scene, position))
    if model.scene.loops:
        assembly = Assembly(model)
        if loaded:
            x, push = assembly.rest(x, model.actuated)
            return mass_matrix(model, x), assembly.stiffness(x, push), x
        x = assembly.position(x, model.actuated)
    elif loaded:
        x = rest_shape(model, x[: model.joints])
        return mass_matrix(model, x), stiffness_matrix(model, x), x
    return mass_matrix(model, x), elastic_stiffness(model, x), x


def closed_modes(
    model: Model, x: np.ndarray, mass: np.ndarray, stiffness: np.ndarray, locked: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Squared angular frequencies (k,), rising, and shapes (n, k) of the motions that keep loops closed."""
    assembly = Assembly(model)
    held = model.actuated if locked else np.zeros_like(model.actuated)
    ways = assembly.motions(x, held)
    mass, stiffness = ways.T @ mass @ ways, ways.T @ stiffness @ ways
    if not len(mass):
        return np.zeros(0), np.zeros((len(x), 0))
    values, shapes = eigh(stiffness, mass)
    free = min(assembly.mobility(x, held), len(values) - 1)
    squared = squared_frequencies(mass, stiffness, abs(values[free]) if free else 0.0)
    return np.maximum(squared, 0.0), ways @ shapes


def eigenvalues(
    mass: np.ndarray, stiffness: np.ndarray, held: np.ndarray, locked: bool, loaded: bool
) -> np.ndarray:
    """(n,) squared angular frequencies, rising, never negative; `held` are the unknowns that motors turn."""
    if len(mass) == len(held):
        return np.zeros(0 if locked else len(held))
    rest = np.setdiff1d(np.arange(len(mass)), held)
    fixed = squared_frequencies(mass[np.ix_(rest, rest)], stiffness[np.ix_(rest, rest)], 0.0)
    if locked:
        return fixed
    free = squared_frequencies(mass, stiffness, fixed[0])
    if not loaded:
        free[: len(held)] = 0.0  # the joints turn freely, whatever rounding makes of it
    return np.maximum(free, 0.0)


def squared_frequencies(mass: np.ndarray, stiffness: np.ndarray, shift: float) -> np.ndarray:
    """(n,) rising eigenvalues of K - s M; K + shift M is positive definite.

    K spans so many decades with many elements that rounding in it drowns the lowest modes: those come from
    its inverse, the others directly.
    """
    low = 1.0 / eigh(mass, stiffness + shift * mass, eigvals_only=True)[::-1] - shift
    high = eigh(stiffness, mass, eigvals_only=True)
    return np.where(high < np.sqrt(abs(low[0] + shift) * high[-1]), low, high)


def strain_energies(model: Model, displacement: np.ndarray) -> np.ndarray:
    """(L, 4) linear strain energy of nodal displacements (N, 6) in link frames, J, by link and kind."""
    scene = model.scene
    found = np.zeros((len(scene.links), len(KINDS)))
    for n, link in enumerate(scene.links):
        if link.beam is None or not link.flexible:
            continue
        nodes = np.flatnonzero(model.node_link == n)
        rows = displacement[nodes].reshape(-1, 2, 3) @ model.axes[n]
        step = link.length / (len(nodes) - 1)
        e = element_row(scene, link, 0, step, True)
        flat = rows.reshape(-1, 6)
        difference = np.diff(flat, axis=0)
        in_z = np.column_stack([flat[:-1, [1, 5]], flat[1:, [1, 5]]])
        in_y = np.column_stack([flat[:-1, [2, 4]], flat[1:, [2, 4]]]) * [1.0, -1.0, 1.0, -1.0]
        bend_z = bending_stiffness(e[BEND_Z], e[LENGTH], e[SHEAR_Z])
        bend_y = bending_stiffness(e[BEND_Y], e[LENGTH], e[SHEAR_Y])
        found[n] = (
            0.5 * e[AXIAL] * np.sum(difference[:, 0] ** 2),
            0.5 * e[TORSION] * np.sum(difference[:, 3] ** 2),
            0.5 * np.einsum("ei,ij,ej->", in_y, bend_y, in_y),
            0.5 * np.einsum("ei,ij,ej->", in_z, bend_z, in_z),
        )
    return found
