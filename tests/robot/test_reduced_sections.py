"""Sections and twists of a reduced link to second order: with all modes kept, they do what the full one's do.

The line's mass is taken out, which the full model shifts along its elements and the reduced one does not.
"""

import dataclasses

import numpy as np
import pytest
from scenes import link, robot

from flexsim_node import load_scene
from flexsim_node.elements.beam import INERTIA_Y, INERTIA_Z, MASS
from flexsim_node.equations.dynamics.energy import energy
from flexsim_node.equations.dynamics.residual import residual
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import Model, build_model
from flexsim_node.model.reduced.layout import CENTRELINE, MASS_GRAM, SHAPE

pytestmark = pytest.mark.equations
ELEMENTS, SEED = 4, 5


def sections_alone(scene: dict, planar: bool) -> Model:
    """Its model, with a thousand times the sections' inertia and no mass of the line."""
    model = build_model(load_scene(scene), planar=planar)
    element, modal = model.chain.element.copy(), model.chain.modal.copy()
    element[:, MASS] = 0.0
    element[:, [INERTIA_Y, INERTIA_Z]] *= 1e3
    for row in model.chain.reduced:
        functions = int(row[CENTRELINE])
        modal[row[MASS_GRAM] : row[MASS_GRAM] + functions * functions] = 0.0
    return dataclasses.replace(model, chain=model.chain._replace(element=element, modal=modal))


def of_modes(full: Model, reduced: Model) -> np.ndarray:
    """(n, n) the full robot's unknowns for unit unknowns of the reduced one, whose last link is reduced."""
    n, joints, b = full.unknowns, full.joints, len(full.chain.dofs)
    at = int(reduced.chain.reduced[-1, SHAPE])
    own = 2 * b + n - joints - b
    shape = reduced.chain.modal[at : at + (ELEMENTS + 1) * b * own].reshape(ELEMENTS + 1, b, own)
    out = np.zeros((n, n))
    out[:joints, :joints] = np.eye(joints)
    out[joints:, joints:] = shape[1:, :, b:].reshape(n - joints, own - b)
    return out


@pytest.mark.parametrize("planar", [True, False])
def test_sections_turn_as_in_the_full_link(planar):
    """Forces and energy, elastic and of inertia, in a chain whose links turn about skew axes."""
    rigid = link("a", {"a": 0.3, "alpha": 0.0 if planar else 0.7}, 0.03, 0.002, flexible=False)
    dh = {"a": 0.5} if planar else {"a": 0.5, "d": 0.2}
    scenes = []
    for keys in ({}, {"reduction": {"modes": 3 * (ELEMENTS - 1) * (1 if planar else 2)}}):
        strip = link("b", dh, 0.03, 0.002, beam={"elements": ELEMENTS}, **keys)
        scenes.append(robot(rigid, strip, gravity=[0.0, 0.0, 0.0], erls={"zeroed": "root"}))
    full, reduced = (sections_alone(scene, planar) for scene in scenes)
    assert full.unknowns == reduced.unknowns
    back = of_modes(full, reduced)
    rng = np.random.default_rng(SEED)
    x, v, a = (size * rng.standard_normal(full.unknowns) for size in (0.05, 2.0, 2.0))
    x[full.joints :] /= np.maximum(1.0, np.max(np.abs(back), axis=0)[full.joints :])
    none = np.zeros_like(x)

    def forces(model, x, v, a):
        out = np.zeros(model.unknowns)
        residual(model.chain, workspace(model.chain), x, v, a, np.zeros(model.joints), out)
        return out

    def compared(v, a):
        return back.T @ forces(full, back @ x, back @ v, back @ a), forces(reduced, x, v, a)

    still = compared(none, none)
    assert np.allclose(*still, rtol=0, atol=1e-12 * np.max(np.abs(still)))
    for rate, acceleration in ((v, none), (none, a), (v, a)):
        one, two = (moved - rest for moved, rest in zip(compared(rate, acceleration), still, strict=True))
        assert np.max(np.abs(one)) > 1e-2
        assert np.allclose(one, two, rtol=0, atol=1e-14 * np.max(np.abs(still)) + 1e-12)
    found = []
    for model, place, rate in ((full, back @ x, back @ v), (reduced, x, v)):
        out = np.zeros(3)
        energy(model.chain, workspace(model.chain), place, rate, out)
        found.append(out[:2])
    assert np.allclose(*found, rtol=1e-9)
