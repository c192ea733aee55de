"""Loads on bent ends change a robot's stiffness as they do in a frame of geometrically exact beams.

The reference is independent_frame.py, extrapolated to the limit of fine elements (frame_figures.py keeps what
it gives); flexsim's own elements are extrapolated likewise. Bounds: half a per cent of a frequency under the
full load, and of the largest of the first four frequencies' slopes by load at small load.
"""

import json

import numpy as np
import pytest
from frame_figures import (
    FILE,
    MODES,
    SIDE_FORCE,
    SIDE_GRAVITY,
    digest,
    entries,
    pose_of,
    pulled,
)
from independent_frame import extrapolated, torsion_constant
from loaded_scenes import LOADED_ENDS, SIDE_LOADS, SPUN, WEIGHED, WRENCHES, part
from loaded_scenes import spun as weightless

from flexsim_node import load_scene, natural_frequencies, simulate, static_equilibrium

FORMULATIONS = ("erls", pytest.param("co_moving", marks=pytest.mark.nightly))
COUNT = 4  # elements of a link, and twice as many
WITHIN = 5e-3
KEPT = json.loads(FILE.read_text())


def kept(name):
    """The frame's figures of that name."""
    return np.array(KEPT[name]["value"])


def test_kept_figures_belong_to_the_scenes():
    """Every figure was made of its scene as it is now."""
    assert {name: entry["scene"] for name, entry in KEPT.items()} == {
        name: digest(scene) for name, (_, _, scene) in entries().items()
    }


@pytest.mark.parametrize(
    "name",
    ["weighed/payload above/0.1", "spun/body beyond the tip/1", "loaded_end/strip/moment in its plane"],
)
def test_kept_figures_are_the_frames(name):
    """Made again, they come out the same."""
    of, arguments, _ = entries()[name]
    assert np.allclose(of(*arguments), kept(name), rtol=1e-6, atol=1e-9)


def with_elements(scene, count, **more):
    """The scene read, each beam in `count` elements."""
    beams = [k for k, x in enumerate(scene["links"]) if "beam" in x]
    return load_scene(scene, {f"links.{k}.beam.elements": count for k in beams} | more)


def weighed(name, part_of_it, formulation):
    """(MODES,) frequencies of flexsim under a part of the weight."""
    scene = WEIGHED[name]

    def at(count):
        read = with_elements(scene, count, formulation=formulation, **pulled(scene, part_of_it))
        return natural_frequencies(read, pose_of(scene), loaded=True)[:MODES]

    return extrapolated(at, COUNT)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("name", WEIGHED)
def test_weight_changes_frequencies(name, formulation):
    """Slope by weight at first order; frequency under the full weight.

    There the ERLS is off by the order of the squared elastic rotation: that counts where it is more.
    """
    right = kept(f"weighed/{name}/0.1") - kept(f"weighed/{name}/-0.1")
    found = weighed(name, 0.1, formulation) - weighed(name, -0.1, formulation)
    assert np.max(np.abs(found - right)) < WITHIN * np.max(np.abs(right))
    scene = with_elements(WEIGHED[name], COUNT, formulation=formulation)
    turned = np.max(np.abs(static_equilibrium(scene, pose_of(WEIGHED[name])).node_displacement[:, 3:]))
    within = max(WITHIN, 1.5 * turned**2) if formulation == "erls" else WITHIN
    assert np.allclose(weighed(name, 1.0, formulation), kept(f"weighed/{name}/1"), rtol=within)


@pytest.mark.parametrize("name", ["payload above", "L in the plane, up", "column with a rigid link on top"])
def test_weight_changes_frequencies_of_reduced_links(name):
    """Reduced links feel their loads like those with all elements."""
    scene = WEIGHED[name]
    reduced = with_elements(scene, 12, **{"reduction": {"modes": 8}})
    found = natural_frequencies(reduced, pose_of(scene), loaded=True)[:2]
    unloaded = natural_frequencies(reduced, pose_of(scene))[:2]
    right = kept(f"weighed/{name}/1")[:2]
    assert np.max(np.abs(right / unloaded - 1.0)) > 0.05
    assert np.allclose(found, right, rtol=WITHIN)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("name", SIDE_LOADS)
def test_weight_yields_to_a_side_load(name, formulation):
    """A loaded robot gives way to a load across its own as far as the frame, in space and in the plane."""
    scene, pose = WEIGHED[name], pose_of(WEIGHED[name])

    def at(count):
        ends = []
        for sign in (1.0, -1.0):
            gravity = np.array(scene["gravity"]) + sign * SIDE_GRAVITY * np.array(SIDE_LOADS[name])
            read = with_elements(scene, count, formulation=formulation, gravity=gravity.tolist())
            ends.append(static_equilibrium(read, pose).link_end)
        return (ends[0] - ends[1]) / (2.0 * SIDE_GRAVITY)

    right, found = kept(f"sideways/{name}"), extrapolated(at, COUNT)
    assert np.max(np.abs(found - right)) < WITHIN * np.max(np.abs(right))


def spun(name, part_of_it, formulation):
    """(MODES,) frequencies of flexsim at a part of the spin."""
    scene, spin = SPUN[name]
    pose = pose_of(scene)
    rates = [part_of_it * spin] + [0.0] * (len(pose) - 1)

    def at(count):
        return natural_frequencies(
            with_elements(scene, count, formulation=formulation), pose, velocity=rates
        )[:MODES]

    return extrapolated(at, COUNT)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("name", SPUN)
def test_spin_changes_frequencies(name, formulation):
    """Squared frequencies grow with the squared spin at first order; at full spin the frequencies hold."""
    right = kept(f"spun/{name}/0.3") ** 2 - kept(f"spun/{name}/0") ** 2
    found = spun(name, 0.3, formulation) ** 2 - spun(name, 0.0, formulation) ** 2
    # the frame's lumped masses leave up to 1e-4 of a squared frequency
    noise = 2e-4 * kept(f"spun/{name}/0") ** 2
    assert np.all(np.abs(found - right) < WITHIN * np.max(np.abs(right)) + noise)
    assert np.allclose(spun(name, 1.0, formulation), kept(f"spun/{name}/1"), rtol=WITHIN)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_body_beyond_a_spun_tip(formulation):
    """A mass on a rigid arm beyond a strip's tip: stiffened at any spin, as the pulled beam's equation says.

    P = m w^2 (L + c) pulls at the strip's end and, by P c, against its turning.
    """
    length, arm, mass, width, depth = 0.6, 0.25, 0.5, 0.03, 0.002
    strip = part("strip", {"a": length}, width, depth)
    tool = part("tool", {"a": arm}, joint={"type": "fixed"}, rigid={"mass": mass})
    scene = load_scene(
        weightless(strip, tool),
        {"links.0.beam.density": 10.001, "links.0.beam.elements": 12, "formulation": formulation},
    )
    bending = 7e10 * width * depth**3 / 12
    for spin in (10.0, 40.0, 60.0):
        pull = mass * spin**2 * (length + arm)
        a = np.sqrt(pull / bending)
        cosh, sinh = np.cosh(a * length), np.sinh(a * length)
        # w = A (cosh ax - 1) + B (sinh ax - a x): end's deflection and slope, force and moment there
        shape = np.array([[cosh - 1, sinh - a * length], [a * sinh, a * (cosh - 1)]])
        force = pull * shape[1] - bending * a**3 * np.array([sinh, cosh])
        moment = bending * a**2 * np.array([cosh, sinh])
        stiffness = np.array([force, moment]) @ np.linalg.inv(shape)
        stiffness[1, 1] += pull * arm
        lever = np.array([1.0, arm])
        right = np.sqrt(1.0 / (lever @ np.linalg.solve(stiffness, lever)) / mass) / 2 / np.pi
        found = natural_frequencies(scene, [0.0], velocity=[spin])[0]
        assert found == pytest.approx(right, rel=WITHIN)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_propeller_moment(formulation):
    """A flat plate on a thin spun rod: w^2 = (G J / L + spin^2 (Izz - Iyy)) / Ixx, which keeps it flat."""
    length, side, spin = 0.3, 0.003, 80.0
    inertia = np.array([3e-5, 1e-6, 3.1e-5])
    plate = {"mass": 0.02, "inertia": np.diag(inertia).tolist()}
    rod = part("rod", {"a": length}, side, side, payload=plate)
    scene = load_scene(weightless(rod), {"links.0.beam.density": 11.0, "formulation": formulation})
    stiffness = 7e10 / 2.6 * torsion_constant(side, side) / length
    right = np.sqrt((stiffness + spin**2 * (inertia[2] - inertia[1])) / inertia[0]) / 2 / np.pi
    still = np.sqrt(stiffness / inertia[0]) / 2 / np.pi
    assert right > 1.05 * still
    found = natural_frequencies(scene, [0.0], velocity=[spin])
    assert np.min(np.abs(found - right)) < 2e-3 * right


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_torsion_of_a_spun_strip(formulation):
    """Each section is such a plate, and the pull of what is beyond untwists it.

    w^2 = w0^2 + spin^2 ((Iz - Iy)/(Iz + Iy) + pi^2/12 + 1/4): Rayleigh's quotient of sin(pi x/(2 L)) with the
    propeller moment and the torsion stiffness N Ip/A, N = mu spin^2 (L^2 - x^2)/2.
    """
    length, width, depth, spin = 0.6, 0.03, 0.0008, 120.0
    strip = part("strip", {"a": length}, width, depth)
    scene = load_scene(weightless(strip), {"links.0.beam.elements": 12, "formulation": formulation})
    iy, iz = width * depth**3 / 12, depth * width**3 / 12
    rod = 7e10 / 2.6 * torsion_constant(width, depth) / (2700 * (iy + iz))
    still = np.pi / 2 / length * np.sqrt(rod)
    share = (iz - iy) / (iz + iy) + np.pi**2 / 12 + 0.25
    right = np.sqrt(still**2 + spin**2 * share) / 2 / np.pi
    # without bending across, only torsion and motions in the plane are left
    effects = scene.effects.model_copy(update={"bending_y": False})
    found = natural_frequencies(scene.model_copy(update={"effects": effects}), [0.0], velocity=[spin])
    assert right > 1.06 * still / 2 / np.pi
    assert np.min(np.abs(found - right)) < 2e-3 * right


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("wrench", WRENCHES)
@pytest.mark.parametrize("name", LOADED_ENDS)
def test_wrench_changes_how_an_end_gives_way(name, wrench, formulation):
    """A small side force moves an end that a wrench loads, directions fixed, as far as the frame's."""
    scene = LOADED_ENDS[name]
    load = f"base:{scene['links'][-1]['name']}"

    def settled(count, sign):
        """Where the end comes to rest, strongly damped."""
        damping = {"damping.beta": 0.3, "solver.step": 0.02, "formulation": formulation}
        damped = with_elements(scene, count, **damping)
        held = {joint: (lambda t: (0.0, 0.0, 0.0)) for joint in damped.joint_names}
        pressed = np.array(WRENCHES[wrench]) + sign * SIDE_FORCE * np.eye(6)[2]
        run = simulate(
            damped, duration=8.0, sample_period=4.0, wrench={load: lambda t: pressed}, prescribed=held
        )
        assert run.status == "ok"
        assert np.allclose(run.link_end[-1, -1], run.link_end[-2, -1], atol=1e-6)
        return run.link_end[-1, -1]

    right = kept(f"loaded_end/{name}/{wrench}")
    found = extrapolated(lambda n: (settled(n, 1.0) - settled(n, -1.0)) / (2.0 * SIDE_FORCE), COUNT)
    assert np.max(np.abs(found - right)) < WITHIN * np.max(np.abs(right))
