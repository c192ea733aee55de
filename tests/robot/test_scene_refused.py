"""A wrong scene is refused in one line: the file, the line, the key and what would be right."""

import pytest
from endless_files import endless_files
from scenes import CONFIG, two_link

from flexsim_node import SceneError, load_scene, simulate

TEXT = """\
model: robot
name: test
gravity: [0.0, -9.81, 0.0]
damping: {alpha: 2.0, beta: 5.0e-4}
links:
  - name: link_1
    dh: {a: 0.5, alpha: 0.0, d: 0.0, theta: 0.0}
    joint: {name: joint_1, type: revolute}
    beam: {width: 0.03, depth: 0.01, density: 7840.0, youngs_modulus: 2.0e11, elements: 2}
  - name: link_2
    dh: {a: 0.4}
    joint: {name: joint_2}
    beam: {width: 0.01, depth: 0.02, density: 7830.0, youngs_modulus: 2.1e11, elements: 3}
    payload: {mass: 0.5, inertia: [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.2]]}
erls: {zeroed: root}
initial: {position: [0.0, 0.0], velocity: [0.0, 0.0], shape: undeformed}
effects: {gravity: true, shear: false}
solver: {method: rosenbrock_w, step: 1.0e-3}
"""


def listed(*dofs):
    return f"zeroed: [{', '.join('{' + dof + '}' for dof in dofs)}]"


ROOT_2 = "link: link_2, node: 0, dof: rz"


@pytest.mark.parametrize(
    ("right", "wrong", "line", "said"),
    [
        ("gravity:", "gravitiy:", 3, "gravitiy: unknown key; did you mean 'gravity'?"),
        ("width: 0.03", "widht: 0.03", 9, "links.0.beam.widht: unknown key; did you mean 'width'"),
        ("shear:", "sheer:", 17, "effects.sheer: unknown key; did you mean 'shear'?"),
        ("step:", "stepp:", 18, "solver.stepp: unknown key; did you mean 'step'?"),
        ("mass: 0.5", "mas: 0.5", 14, "links.1.payload.mas: unknown key; did you mean 'mass'?"),
        ("width: 0.03", "width: 30 mm", 9, "links.0.beam.width: is '30 mm'; give a number (without"),
        ("width: 0.03", "width: 30", 9, "at most 10 m (metres, not millimetres)"),
        ("width: 0.03", "width: -0.03", 9, "is -0.03; give more than 0"),
        ("width: 0.03", "width: 0", 9, "is 0; give more than 0"),
        ("a: 0.5", "a: 500", 7, "links.0.dh.a: is 500; give at least -100 and at most 100 m (metres"),
        ("alpha: 0.0", "alpha: 90", 7, "rad (radians, not degrees)"),
        ("density: 7840.0", "density: 7.84", 9, "steel has 7800 kg/m3, not 7.8 g/cm3"),
        ("2.0e11", "200", 9, "links.0.beam.youngs_modulus: is 200; give more than 10000"),
        ("2.0e11", "200 GPa", 9, "give a number (without its unit; SI units are understood)"),
        ("step: 1.0e-3", "step: 1 ms", 18, "solver.step: is '1 ms'; give a number"),
        ("step: 1.0e-3", "step: 0", 18, "solver.step: is 0; give more than"),
        ("step: 1.0e-3", "step: 10", 18, "at most 1 s"),
        ("density: 7840.0, ", "", 9, "links.0.beam.density: is missing; give it"),
        ("depth: 0.01, ", "", 9, "links.0.beam: lacks depth; give width, depth"),
        ("width: 0.03, depth: 0.01, ", "", 9, "has no section; give width and depth, or area"),
        ("width: 0.03,", "area: 1.0e-4, width: 0.03,", 9, "has both width/depth and area"),
        ("elements: 2}", "elements: 0}", 9, "links.0.beam.elements: is 0; give at least 1"),
        ("elements: 2}", "elements: 2.5}", 9, "is 2.5; give a whole number"),
        ("elements: 2}", "elements: two}", 9, "is 'two'; give a whole number"),
        ("elements: 2}", "elements: 9999}", 9, "is 9999; give at most 1000"),
        ("elements: 2}", "elements: 2, poissons_ratio: 0.7}", 9, "poissons_ratio: is 0.7; give"),
        ("name: link_2", "name: link_1", 10, "links.1.name: is 'link_1' like links.0; give each"),
        ("joint_2", "joint_1", 12, "links.1.joint.name: is 'joint_1' like links.0; give each"),
        ("name: test\n", "", 1, "name: is missing; give it"),
        ("name: link_2", "name: ''", 10, "links.1.name: is ''; give a name"),
        ("name: link_2", "name: 7", 10, "links.1.name: is 7; give a name"),
        ("dh: {a: 0.4}", "dh: {a: 0.4}\n    parent: link_2", 12, "parent: is 'link_2'; give base or"),
        ("dh: {a: 0.4}", "dh: {a: 0.4}\n    parent: 3", 12, "links.1.parent: is 3; give a name"),
        ("type: revolute", "type: revolut", 8, "give 'fixed', 'revolute' or 'prismatic'"),
        ("type: revolute", "type: fixed", 16, "initial.position: has 2 values for 1 moving joints"),
        ("type: revolute", "effort_limit: -1", 8, "effort_limit: is -1; give more than 0"),
        ("type: revolute", "stiffness: 100.0", 8, "stiffness: is 100, but behind a spring the motor moves"),
        ("joint_1, type: revolute", "joint_1, gear_ratio: 30.0", 8, "gear_ratio: is 30 without a rotor"),
        ("joint_1, type: revolute", "joint_1, coulomb_speed: 0.1", 8, "coulomb_speed: is 0.1 without a cou"),
        ("type: revolute", "actuated: false, effort_limit: 3.0", 8, "effort_limit: is 3, but the joint"),
        ("mass: 0.5, ", "", 14, "links.1.payload.inertia: is given, but the body has no mass; give its mass"),
        ("mass: 0.5, inertia: [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.2]]", "center_of_mass: [0.1, 0, 0]", 14,
         "links.1.payload.center_of_mass: is given, but the body has no mass"),
        ("beta: 5.0e-4", "alpha_form: thesys", 4, "alpha_form: is 'thesys'; give 'elastic' or 'thesis'"),
        ("alpha: 2.0", "alpha_form: thesis", 4, "damping.alpha_form: is given without an alpha"),
        ("effects:", "torque: [{joint: joint_1, type: constant, frequency: 2.0}]\neffects:", 17,
         "torque.0.frequency: has no meaning for type constant"),
        ("effects:",
         "torque: [{joint: joint_1, type: table, time: [0], value: [1], amplitude: 2}]\neffects:", 17,
         "torque.0.amplitude: has no meaning for a table"),
        ("a: 0.5", "a: .nan", 7, "links.0.dh.a: is nan; give a finite number"),
        ("a: 0.5", "a: .inf", 7, "links.0.dh.a: is inf; give a finite number"),
        ("a: 0.5", "a: true", 7, "links.0.dh.a: is True; give a number"),
        ("a: 0.5", "a: [0.5]", 7, "links.0.dh.a: is [0.5]; give a number"),
        ("a: 0.5", "a: 0.0", 6, "links.0: has a beam but no length; give dh a or d, or replace"),
        ("[0.0, -9.81, 0.0]", "[0.0, -9.81]", 3, "gravity: is a list of 2; give at least 3"),
        ("[0.0, -9.81, 0.0]", "-9.81", 3, "gravity: is -9.81; give a list"),
        ("[0.0, -9.81, 0.0]", "[0, -9.81, down]", 3, "gravity.2: is 'down'; give a number"),
        ("alpha: 2.0", "alpha: -2.0", 4, "damping.alpha: is -2; give at least 0"),
        ("{alpha: 2.0, beta: 5.0e-4}", "0.1", 4, "damping: is 0.1; give keys such as alpha, beta"),
        ("position: [0.0, 0.0]", "position: [0.0]", 16, "has 1 values for 2 moving joints; give 2"),
        ("position: [0.0, 0.0]", "position: 0.0", 16, "initial.position: is 0.0; give a list"),
        ("shape: undeformed", "shape: bent", 16, "is 'bent'; give 'undeformed' or 'static'"),
        ("shear: false", "shear: of", 17, "effects.shear: is 'of'; give true, false or auto"),
        ("shear: false", "shear: auto", 17, "effects: leave shear to auto, but the scene has no tolerance"),
        ("{gravity: true, shear: false}", "[shear]", 17, "effects: is a list of 1; give keys such"),
        ("rosenbrock_w", "rosenbrock", 18, "solver.method: is 'rosenbrock'; give 'rosenbrock_w'"),
        ("zeroed: root", "zeroed: rot", 15, "erls.zeroed: is 'rot'; give 'root', 'chord' or"),
        ("zeroed: root", listed("link: link_9, node: 1, dof: rz", ROOT_2), 15, "zeroed.0.link: is 'li"),
        ("zeroed: root", listed("link: link_1, node: 1, dof: rw", ROOT_2), 15, "zeroed.0.dof: is 'rw'"),
        ("zeroed: root", listed("link: link_1, node: -1, dof: rz", ROOT_2), 15, "node: is -1; give at"),
        ("zeroed: root", listed("link: link_1, node: 9, dof: rz", ROOT_2), 15, "of link_1 is node 2"),
        ("mass: 0.5", "mass: -1", 14, "links.1.payload.mass: is -1; give at least 0"),
        ("[[0.1, 0, 0]", "[[0.9, 0, 0]", 14, "none may exceed the sum of the other two"),
        ("[[0.1, 0, 0]", "[[0.1, 1, 0]", 14, "not symmetric; give a symmetric 3 x 3 matrix"),
        ("payload: {", "rigid: {", 10, "has both beam and rigid; give one of the two"),
        ("- name: link_2", "- link_2\n  - name: link_2", 10, "links.1: is 'link_2'; give keys such"),
        ("model: robot", "model: robots", 1, "model: is 'robots'; give 'robot'"),
        ("model: robot\n", "", 1, "model: is None; give 'robot'"),
        ("links:", "links: {", 6, "not YAML"),
        ("name: test", "\tname: test", 2, "not YAML"),
        ("name: test", "name: test\nname: again", 3, "not YAML: found duplicate key"),
        (TEXT, "- robot\n", 1, "not a scene; give keys such as model, name, links"),
        (TEXT, "", 1, "not a scene"),
    ],
)  # fmt: skip
def test_refused_with_its_place(tmp_path, right, wrong, line, said):
    path = tmp_path / "robot.yaml"
    assert right in TEXT
    path.write_text(TEXT.replace(right, wrong, 1))
    with pytest.raises(SceneError) as refusal:
        load_scene(path)
    message = str(refusal.value)
    assert message.startswith(f"{path}:{line}: ")
    assert said in message
    assert "\n" not in message


FIXED_WITH = {
    "stiffness": 100.0, "damping": 1.0, "rotor_inertia": 0.1, "gear_ratio": 2.0, "viscous_friction": 0.1,
    "coulomb_friction": 0.1, "coulomb_speed": 0.1, "effort_limit": 3.0, "actuated": False,
}  # fmt: skip


@pytest.mark.parametrize("key", FIXED_WITH)
def test_a_fixed_joint_has_nothing_that_moves(tmp_path, key):
    """A spring, a motor or friction on it would be ignored."""
    path = tmp_path / "robot.yaml"
    fixed = f"{{type: fixed, {key}: {str(FIXED_WITH[key]).lower()}}}"
    path.write_text(TEXT.replace("{name: joint_1, type: revolute}", fixed))
    with pytest.raises(SceneError) as refusal:
        load_scene(path)
    assert str(refusal.value).startswith(f"{path}:8: links.0.joint.{key}: is given, but the joint is fixed")
    right = TEXT.replace("{name: joint_1, type: revolute}", "{type: fixed}")
    path.write_text(right.replace("[0.0, 0.0]", "[0.0]"))
    assert load_scene(path).joint_names == ("joint_2",)


def test_a_reduction_without_a_beam_is_refused():
    """A rigid body has no modes to be reduced to."""
    scene = two_link()
    scene["links"].append({"name": "w", "dh": {}, "rigid": {"mass": 1.0}, "reduction": {"modes": 2}})
    with pytest.raises(SceneError, match=r"links.2.reduction: is given, but the link has no beam"):
        load_scene(scene)


def test_the_text_itself_is_right(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_text(TEXT)
    assert simulate(load_scene(path), duration=0.002).status == "ok"


def test_scenes_run_no_code(tmp_path):
    """A YAML tag that names Python is data."""
    trace = tmp_path / "ran"
    path = tmp_path / "robot.yaml"
    attack = f"!!python/object/apply:os.system ['touch {trace}']"
    path.write_text(TEXT.replace("name: test", f"name: {attack}"))
    with pytest.raises(SceneError, match="name"):
        load_scene(path)
    assert not trace.exists()


@pytest.mark.parametrize(
    ("content", "said"), [(None, "no such file; give the path"), (b"\xff\xfe\x00", "can't be read")]
)
def test_files_that_are_none(tmp_path, content, said):
    path = tmp_path / "robot.yaml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError, match=said):
        load_scene(path)


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        ({"solver.stepp": 1e-3}, "override: solver.stepp: unknown key; did you mean 'step'?"),
        ({"solver.step": "fast"}, "override: solver.step: is 'fast'; give a number"),
        ({"solver.step": float("nan")}, "give a finite number"),
        ({"links.link_9.beam.elements": 3}, "no 'link_9' in links; give one of link_1, link_2"),
        ({"links.7.beam.elements": 3}, "no '7' in links; give one of link_1, link_2"),
        ({"links.link_1.beam.width.x": 3}, "links.link_1.beam.width is 0.03 and has no keys below it"),
        ({"links": 3}, "override: links: is 3; give a list"),
        ({"solver": None}, "override: solver: is None; give keys such as method"),
        ({3: 4}, "override: 3: unknown key"),
        ({"model": "door"}, "give 'robot'"),
    ],
)
def test_overrides_that_do_not_fit(overrides, said):
    with pytest.raises(SceneError) as refusal:
        load_scene(CONFIG / "planar_double_pendulum.yaml", overrides)
    assert said in str(refusal.value)
    assert "override" in str(refusal.value)


def test_a_scene_from_a_dict_is_checked_too():
    scene = two_link()
    scene["links"][1]["beam"]["width"] = "3 cm"
    with pytest.raises(SceneError, match=r"^scene: links.1.beam.width: is '3 cm'; give a number"):
        load_scene(scene)


def test_files_that_never_end(tmp_path):
    """They are refused before they are unfolded, or waited for."""
    for path, said in endless_files(tmp_path, "robot"):
        with pytest.raises(SceneError, match=said):
            load_scene(path)
