"""A reduced link is the full one on fewer coordinates: same equations and outputs."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot

from flexsim_node import SceneError, load_scene, natural_frequencies, static_equilibrium
from flexsim_node.analysis.linearization import unknown_names
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.equations.dynamics.residual import link_forces, residual, stiffness_times
from flexsim_node.equations.dynamics.tangent import differences
from flexsim_node.equations.kinematics.nodal_motion import place, shape
from flexsim_node.equations.reduced import space
from flexsim_node.equations.solve.factorization import factorize, set_scale
from flexsim_node.equations.solve.substitution import solve
from flexsim_node.model.chain import ACCELERATION, COUNT, DISPLACEMENT, FIRST, RATE, workspace
from flexsim_node.model.model import build_model
from flexsim_node.model.reduced.layout import MODES, SHAPE
from flexsim_node.motion.rest_shape import rest_shape
from flexsim_node.sensors.instruments import Sensors
from flexsim_node.sensors.observation import Observation

INERTIA = [[0.02, 0.001, 0.002], [0.001, 0.03, -0.003], [0.002, -0.003, 0.025]]
PAYLOAD = {"mass": 1.3, "center_of_mass": [0.02, 0.03, -0.04], "inertia": INERTIA}
FLAT = {"mass": 0.7, "center_of_mass": [0.05, 0.02, 0.0], "inertia": np.diag([0.01, 0.02, 0.025]).tolist()}
SOFT = {"elements": 4, "youngs_modulus": 2e9}
DAMPING = {"alpha": 0.3, "beta": 1e-3}

pytestmark = pytest.mark.equations


def planar(effects=None, beam=None, **keys):
    """A rigid link, then a flexible one with a payload, in a plane."""
    return robot(
        link("rigid", {"a": 0.3}, flexible=False),
        link("soft", {"a": 0.5}, 0.03, 0.02, beam={**SOFT, **(beam or {})}, payload=FLAT),
        **{"gravity": [1.0, -5.0, 0.0], "damping": DAMPING, "effects": effects or {}, **keys},
    )


def spatial(effects=None, beam=None, **keys):
    """The same with skew joints and gravity askew."""
    return robot(
        link("rigid", {"a": 0.3, "alpha": 0.7, "d": 0.1}, flexible=False),
        link("soft", {"a": 0.5, "alpha": 0.3, "d": 0.1}, 0.03, 0.02, beam={**SOFT, **(beam or {})},
             payload=PAYLOAD),
        **{"gravity": [3.0, -5.0, -7.0], "damping": DAMPING, "effects": effects or {}, **keys},
    )  # fmt: skip


def both(scene, modes):
    """Models of a scene as it is and with every flexible link reduced."""
    return build_model(load_scene(scene)), build_model(load_scene(scene, {"reduction": {"modes": modes}}))


def expansion(full, reduced):
    """(n_full, n_reduced) map of the unknowns, where the flexible links hang on rigid ones.

    It is read from what both models show of their nodes, to first order in the unknowns.
    """
    views, works = [Observation(m) for m in (full, reduced)], [workspace(m.chain) for m in (full, reduced)]
    seen = []
    for model, view, work in zip((full, reduced), views, works, strict=True):

        def shown(x, view=view, work=work):
            view.look(work, x)
            return view.displacement.ravel()

        still = np.zeros(model.unknowns)
        columns = differences(shown, still, np.eye(model.unknowns))
        columns[:, : model.joints] = 0.0
        seen.append(columns)
    m = full.joints
    out = np.zeros((full.unknowns, reduced.unknowns))
    out[:m, :m] = np.eye(m)
    found, gap, _, _ = np.linalg.lstsq(seen[0][:, m:], seen[1][:, m:], rcond=None)
    out[m:, m:] = found
    assert np.max(np.abs(seen[0] @ out - seen[1])) < 1e-12, gap
    return out


CASES = {
    "plain": {"centrifugal": False},
    "shear": {"centrifugal": False, "shear": True},
    "points": {"centrifugal": False, "rotary_inertia": False},
    "points, no torsion": {"centrifugal": False, "rotary_inertia": False, "torsion": False},
    "no torsion": {"centrifugal": False, "torsion": False},
    "no bending y": {"centrifugal": False, "bending_y": False},
    "no axial": {"axial": False},
    "no coriolis": {"centrifugal": False, "coriolis": False},
    "points, no coriolis": {"centrifugal": False, "coriolis": False, "rotary_inertia": False},
}


@pytest.mark.parametrize("erls", ["root", "chord"])
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("build", "modes"), [(planar, 3), (spatial, 7)])
def test_equations_are_the_projected_ones(build, modes, case, erls):
    """Without stiffening the reduced residual is the full one, projected; solutions fit its matrix."""
    check_projection(build(CASES[case], erls={"zeroed": erls}), modes)


@pytest.mark.parametrize("erls", ["root", "chord"])
@pytest.mark.parametrize(("build", "modes"), [(planar, 6), (spatial, 12)])
def test_all_modes_stiffen_as_the_full_model(build, modes, erls):
    """With every mode kept the stress resultants stiffen a bent robot at rest as in the full model."""
    scene = build({"gravity": False, "shear": True}, {"elements": 3}, erls={"zeroed": erls})
    full, reduced = both(scene, modes)
    expand, m = expansion(full, reduced), reduced.joints
    x = 0.02 * np.random.default_rng(7).standard_normal(reduced.unknowns)
    x[reduced.turn[reduced.turn >= 0]] = 0.0  # its square turns the start, on which the modes ride
    forces = []
    for model, state in ((full, expand @ x), (reduced, x)):
        out, still, torque = np.zeros(model.unknowns), np.zeros(model.unknowns), np.zeros(m)
        residual(model.chain, workspace(model.chain), state, still, still, torque, out)
        forces.append(out)
    assert np.max(np.abs(expand.T @ forces[0] - forces[1])) < 1e-12 * np.max(np.abs(forces[1]))
    check_solution(reduced, modes)


def check_projection(scene, modes):
    full, reduced = both(scene, modes)
    expand = expansion(full, reduced)
    rng = np.random.default_rng(modes)
    n, m = reduced.unknowns, reduced.joints
    x, v, a = rng.standard_normal((3, n))
    x[m:] *= 0.01
    torque = rng.standard_normal(m)
    forces = []
    for model, state in ((full, (expand @ x, expand @ v, expand @ a)), (reduced, (x, v, a))):
        out = np.zeros(model.unknowns)
        residual(model.chain, workspace(model.chain), *state, torque, out)
        forces.append(out)
    size = np.max(np.abs(forces[1]))
    assert np.max(np.abs(expand.T @ forces[0] - forces[1])) < 1e-12 * size
    check_solution(reduced, modes)


def check_solution(reduced, seed):
    """Accelerations leave no residual, and the factors are those of M + s K."""
    rng = np.random.default_rng(seed)
    n, m = reduced.unknowns, reduced.joints
    x, v, a = rng.standard_normal((3, n))
    x[m:] *= 0.01
    torque = rng.standard_normal(m)
    work, out = workspace(reduced.chain), np.zeros(n)
    residual(reduced.chain, work, x, v, a, torque, out)
    size = np.max(np.abs(out))
    assert acceleration(reduced.chain, work, x, v, torque, a) == 0
    residual(reduced.chain, work, x, v, a, torque, out)
    assert np.max(np.abs(out)) < 1e-11 * size
    base, column, zero = np.zeros(n), np.zeros(n), np.zeros(n)
    residual(reduced.chain, work, x, v, zero, torque, base)
    matrix, scale = np.zeros((n, n)), 1e-4
    for k, unit in enumerate(np.eye(n)):
        residual(reduced.chain, work, x, v, unit, torque, column)
        matrix[:, k] = base - column
        with pytest.MonkeyPatch.context() as patch:
            # what turns with the links is slow, and not in the factors
            patch.setattr(space, "add_turning", lambda *_: None)
            stiffness_times(reduced.chain, work, unit, scale, column)
        matrix[:, k] += column
    set_scale(reduced.chain, work, scale, 0.0, 0.0)
    place(reduced.chain, work, x)
    assert factorize(reduced.chain, work) == 0
    load = rng.standard_normal(n)
    solve(reduced.chain, work, load, out)
    assert np.max(np.abs(matrix @ out - load)) < 1e-7


@pytest.mark.parametrize(("build", "modes"), [(planar, 3), (spatial, 7)])
def test_forces_of_a_link_whose_start_moves(build, modes):
    """The forces on the start node, on which a flexible link before acts, are the projected ones too."""
    full, reduced = both(build({"centrifugal": False}), modes)
    works = [workspace(m.chain) for m in (full, reduced)]
    b = len(full.chain.dofs)
    table, nodes = reduced.chain.reduced[1], full.scene.links[1].beam.elements + 1
    width = 2 * b + int(table[MODES])
    expand = reduced.chain.modal[table[SHAPE] :][: nodes * b * width].reshape(-1, width)
    rng = np.random.default_rng(3)
    frame = rng.standard_normal(9) * ([0, 0, 1, 1, 1, 0, 0, 0, 1] if b == 3 else np.ones(9))
    first, last = (int(k) for k in full.chain.link[1, [FIRST, COUNT]])
    nodes = slice(first, first + last + 1)
    at = int(reduced.chain.link[1, FIRST]) * b
    for work in works:
        work.frame[1, :9] = frame
    for row in (DISPLACEMENT, RATE, ACCELERATION):
        z = rng.standard_normal(width)
        works[1].node[row].reshape(-1)[at : at + width] = z
        works[0].node[row, nodes] = (expand @ z).reshape(-1, b)
    shape(reduced.chain.reduction, reduced.chain.dofs, reduced.chain, works[1])
    for model, work in zip((full, reduced), works, strict=True):
        link_forces(model.chain, work)
    theirs = expand.T @ works[0].force[nodes].ravel()
    ours = works[1].force.reshape(-1)[at : at + width]
    assert np.max(np.abs(theirs - ours)) < 1e-12 * np.max(np.abs(ours))
    assert works[1].wrench[1] == pytest.approx(works[0].wrench[1], rel=1e-12, abs=1e-12)


def arm(elements=8, damping=0.0, **keys):
    """The anthropomorphic robot of the thesis with finer links."""
    scene = anthropomorphic(damping={"alpha": 0.0, "beta": damping}, **keys)
    for part in scene["links"]:
        part["beam"]["elements"] = elements
    return load_scene(scene)


def reduced_to(modes, scene):
    from flexsim_node.scene.schema import Reduction

    return scene.model_copy(update={"reduction": Reduction(modes=modes)})


def test_frequencies_converge_from_above():
    """Rayleigh-Ritz: each mode more lowers the frequencies towards the full model's, never below."""
    scene, pose = arm(6), [0.3, 0.5, -0.8]
    full = natural_frequencies(scene, pose)
    before = np.full(9, np.inf)
    worst = []
    for modes in (0, 2, 4, 8, 12):  # of which two are axial in the last two
        found = natural_frequencies(reduced_to(modes, scene), pose)[:9]
        assert np.all(found > full[:9] * (1.0 - 1e-9))
        assert np.all(found < before * (1.0 + 1e-9))
        before = found
        print(modes, found / full[:9] - 1.0)
        worst.append(np.max(found / full[:9] - 1.0))
    assert worst[0] > 1e-2  # the modes matter
    assert worst[3] < 2e-4 and worst[4] < 5e-5


def test_planar_frequencies_are_those_of_its_motion():
    """A planar robot's modes are counted in the plane; the ones beyond it do not take their place."""
    scene = load_scene(planar(beam={"elements": 6}), {"reduction.modes": 3})
    flat = build_model(scene)
    found = natural_frequencies(scene, [0.2, 0.4])
    from flexsim_node.equations.dynamics.tangent import elastic_stiffness, mass_matrix

    rooted = build_model(scene.model_copy(update={"erls": scene.erls.model_copy(update={"zeroed": "root"})}))
    x = np.zeros(rooted.unknowns)
    x[:2] = 0.2, 0.4
    own = slice(2, None)
    squared = np.linalg.eigvals(
        np.linalg.solve(mass_matrix(rooted, x)[own, own], elastic_stiffness(rooted, x)[own, own])
    )
    in_plane = np.sort(np.sqrt(squared.real)) / (2.0 * np.pi)
    for frequency in in_plane[:4]:
        assert np.min(np.abs(found / frequency - 1.0)) < 1e-6
    assert flat.planar


def spinning_frequencies(ratio, modes, elements=8):
    """Lowest flap frequencies of a cantilever that spins about its root, over sqrt(EI / (m L^4))."""
    length, inertia, area = 1.0, 1e-8, 1e-3
    beam = {"area": area, "iy": inertia, "iz": inertia, "j": 2e-8, "density": 1000.0, "elements": elements}
    part = link("blade", {"a": length}, None)
    part["beam"] = {**beam, "youngs_modulus": 1e11}
    scene = robot(part, gravity=[0, 0, 0], erls={"zeroed": "root"}, effects={"rotary_inertia": False})
    unit = np.sqrt(1e11 * inertia / (1000.0 * area * length**4))
    keys = {} if modes is None else {"reduction.modes": modes}
    model = build_model(load_scene(scene, keys), planar=False)
    n, work = model.unknowns, workspace(model.chain)
    x, v, zero, torque = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(1)
    v[0] = ratio * unit

    def force(at, acceleration):
        out = np.zeros(n)
        residual(model.chain, work, at, v, acceleration, torque, out)
        return out[1:]

    def tangent(at):
        nudge = 1e-6 * np.eye(n)[1:]
        return -np.array([(force(at + e, zero) - force(at - e, zero)) / 2e-6 for e in nudge]).T

    for _ in range(6):
        x[1:] += np.linalg.solve(tangent(x), force(x, zero))
    mass = -np.array([force(x, e) - force(x, zero) for e in np.eye(n)[1:]]).T
    squared = np.sort(np.linalg.eigvals(np.linalg.solve(mass, tangent(x))).real)
    return np.sqrt(squared[:6]) / unit


@pytest.mark.parametrize(("ratio", "flap", "bound"), [(2.0, 4.13732, 1e-3), (5.0, 6.44954, 2e-3)])
def test_a_spinning_link_stiffens(ratio, flap, bound):
    """Flap and lag frequencies of a rotating cantilever: the tension of spin, falling off towards the end.

    With eight elements the full model's flap frequency is 9e-4 off at ratio 5.
    """
    lag = np.sqrt(flap**2 - ratio**2)
    found = spinning_frequencies(ratio, 6)
    assert found[0] == pytest.approx(lag, rel=2 * bound)
    assert found[1] == pytest.approx(flap, rel=bound)


def test_statics():
    """The ends rest where the full model's do, under end loads and the links' own weight."""
    scene = load_scene(spatial({"centrifugal": False}), {"damping": {}})
    full = static_equilibrium(scene, [0.2, 0.4])
    for modes in (0, 5):
        part = static_equilibrium(reduced_to(modes, scene), [0.2, 0.4])
        assert part.link_end == pytest.approx(full.link_end, abs=1e-9)
        assert part.torque == pytest.approx(full.torque, rel=1e-4)  # the weight's arms, inside the link
    assert np.max(np.abs(full.node_displacement)) > 1e-3


@pytest.mark.parametrize("build", [planar, spatial])
def test_sensors_read_as_on_the_full_link(build):
    """Strain, section forces and poses inside a reduced link that bends and is pulled."""
    places = [{"link": "soft", "fraction": s} for s in (0.0, 0.3, 1.0)]
    sensors = [
        {"name": f"{kind}_{k}", "type": kind, **place, **({"side": "+y"} if kind == "strain_gauge" else {})}
        for kind in ("strain_gauge", "section_force", "pose")
        for k, place in enumerate(places)
    ]
    scene = load_scene(build(beam={"elements": 6}, sensors=sensors))
    q = np.array([0.2, 0.4])
    seen = []
    for modes in (None, 10):
        driven = scene.joint_names
        model = build_model(scene if modes is None else reduced_to(modes, scene), driven=driven)
        view, work, read = Observation(model), workspace(model.chain), Sensors(model)
        x = rest_shape(model, q)
        view.look(work, x)
        read.look(view, work, x, 0.0 * x, 0.0 * x)
        seen.append({name: value.copy() for name, value in read.values.items()})
    # shear is the third derivative of the modes: it converges last
    for kind, bound in (("strain_gauge", 4e-3), ("section_force", 2e-2), ("pose", 1e-5)):
        full, part = (np.array([found[f"{kind}_{k}"] for k in range(3)]) for found in seen)
        assert np.max(np.abs(part - full)) < bound * np.max(np.abs(full)), kind


def test_reduced_and_full_and_rigid_links_together():
    """A robot may mix them: its equations are solved, and its outputs are laid out as ever."""
    scene = load_scene(
        robot(
            link(
                "a", {"a": 0.4, "alpha": 0.9}, beam={**SOFT, "youngs_modulus": 2e10}, reduction={"modes": 5}
            ),
            link("b", {"a": 0.3, "d": 0.2}, beam=SOFT, reduction=False, payload=PAYLOAD),
            link("w", {"alpha": -1.3, "theta": 0.2}, None),
            link("c", {"a": 0.2, "alpha": -0.4, "d": 0.1}, beam=SOFT),
            link("d", {"a": 0.2}, flexible=False),
            reduction={"modes": 3},
        )
    )
    model = build_model(scene)
    assert (model.chain.reduced[:, MODES] >= 0).tolist() == [True, False, False, True, False]
    assert len(model.node_names) == 5 + 5 + 1 + 5 + 2
    names = unknown_names(model)
    assert len(set(names)) == len(names) == model.unknowns and "a/mode_5" in names and "c/4/ry" in names
    rng = np.random.default_rng(5)
    x, v = rng.standard_normal((2, model.unknowns))
    x[model.joints :] *= 0.01
    work, a, out = workspace(model.chain), np.zeros(model.unknowns), np.zeros(model.unknowns)
    torque = np.ones(model.joints)
    assert acceleration(model.chain, work, x, v, torque, a) == 0
    residual(model.chain, work, x, v, 0.0 * a, torque, out)
    size = np.max(np.abs(out))
    residual(model.chain, work, x, v, a, torque, out)
    assert np.max(np.abs(out)) < 1e-10 * size


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"reduction.modes": -1}, "reduction.modes: is -1; give at least 0"),
        ({"reduction.modes": 2.5}, "reduction.modes: is 2.5; give a whole number"),
        ({"reduction": {"modes": 3, "mode": 3}}, "reduction.mode: unknown key; did you mean 'modes'?"),
        ({"reduction": {}}, "reduction.modes: is missing"),
        (
            {"reduction.modes": 3, "erls.zeroed": [{"link": "rigid", "node": 0, "dof": "rz"},
                                                   {"link": "soft", "node": 2, "dof": "rz"}]},
            "erls.zeroed.1.node: is 2, inside soft, which is reduced to its ends and modes; give 0 or 4,",
        ),
        ({"reduction.modes": 10}, "is 10, but soft has 9 dofs between its ends (4 elements in the plane)"),
    ],
)  # fmt: skip
def test_refusals(overrides, words):
    with pytest.raises(SceneError) as problem:
        build_model(load_scene(planar(), overrides))
    assert words in str(problem.value)
