"""`flexsim import`: a robot that exists, from its URDF or xacro to a scene."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import click

from ..terminal.output_file import OutputFile
from ..terminal.report import print_json, print_table, say


def pairs(values: tuple[str, ...], sign: str, option: str) -> dict[str, str]:
    """NAME and value of each; refuses what has no sign between them, and names given twice."""
    found: dict[str, str] = {}
    for value in values:
        name, between, rest = value.partition(sign)
        if not between or not name or not rest:
            raise click.UsageError(f"{option} {value!r}: give NAME{sign}VALUE.")
        if name in found:
            raise click.UsageError(f"{option} {name}: is given twice.")
        found[name] = rest
    return found


def positions(words: tuple[str, ...]) -> dict[str, float]:
    """Where each joint of --hold is held, rad or m."""
    found: dict[str, float] = {}
    for word in words:
        name, equals, value = word.partition("=")
        try:
            place = float(value) if equals else 0.0
        except ValueError:
            place = math.nan
        if not name or not math.isfinite(place):
            raise click.UsageError(f"--hold {word!r}: give JOINT or JOINT=VALUE, in rad or m.")
        if name in found:
            raise click.UsageError(f"--hold {name}: is given twice.")
        found[name] = place
    return found


@click.command(name="import")
@click.argument("robot", metavar="ROBOT.urdf|.xacro", type=click.Path())
@click.option("-o", "--output", type=OutputFile(".yaml", ".yml"), required=True, metavar="SCENE.yaml",
              help="The scene; an existing file is kept unless --force.")  # fmt: skip
@click.option("--beam", "beams", multiple=True, metavar="LINK=SECTION,MATERIAL[,ELEMENTS]",
              help="A link that bends, from its joint to where the next hangs on it. SECTION, in m:"
                   " rectangle:WxD, round:D, tube:OUTSIDExWALL, box:WxDxWALL; MATERIAL: steel, aluminium,"
                   " titanium, or E:DENSITY:POISSON.")  # fmt: skip
@click.option("--with", "additions", type=click.Path(), metavar="FILE.yaml",
              help="Keys of a scene put over the import: links and joints by name (beam, stiffness,"
                   " rotor_inertia), loops, and all others.")  # fmt: skip
@click.option("--keep-fixed", is_flag=True, help="Fixed links stay links; else they are lumped.")
@click.option("--hold", multiple=True, metavar="JOINT[=VALUE]",
              help="A joint that is held, at 0 or at VALUE (rad or m).")  # fmt: skip
@click.option("--hold-mimics", is_flag=True,
              help="Joints that follow others are held where those leave them at the start; else they are"
                   " free.")  # fmt: skip
@click.option(
    "--mend-inertia", is_flag=True, help="Inertias that no body can have become the nearest that one can."
)
@click.option("--arg", "arguments", multiple=True, metavar="NAME:=VALUE", help="An argument of a xacro.")
@click.option("--force", is_flag=True, help="Write over an existing scene.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(robot: str, output: str, beams: tuple[str, ...], additions: str | None, keep_fixed: bool,
            hold: tuple[str, ...], hold_mimics: bool, mend_inertia: bool, arguments: tuple[str, ...],
            force: bool, as_json: bool) -> None:  # fmt: skip
    """Make a scene of a robot's URDF or xacro, and say what was taken, changed, or could not be.

    What is fixed to a link is lumped with it, exactly; where a branch ends with it, its place becomes a named
    point. Motion, mass and gravity are those of the URDF. The scene is checked before it is written.

    \b
    Example:
      flexsim import arm.urdf -o arm.yaml --beam forearm=tube:0.05x0.003,aluminium,4
    """
    begun = time.monotonic()
    words = pairs(beams, "=", "--beam")
    values = pairs(arguments, ":=", "--arg")
    held = positions(hold)
    target = Path(output)
    if target.exists() and not force:
        raise click.ClickException(f"{target} exists already; name another file, or give --force")
    from ..robot_import.account import Account
    from ..robot_import.additions import add, read_additions
    from ..robot_import.determined import check_determined
    from ..robot_import.scene import Choices, scene_of
    from ..robot_import.urdf import read_urdf
    from ..robot_import.writing import scene_text, write_whole
    from ..robot_import.xacro_file import unfold
    from ..robot_import.xml_file import parse_xml, read_xml

    path = Path(robot)
    if path.suffix == ".xacro":
        root = parse_xml(unfold(path, values), f"{path}, unfolded")
    elif values:
        raise click.UsageError("--arg is for a xacro.")
    else:
        root = read_xml(path)
    account = Account()
    choices = Choices(keep_fixed, held, hold_mimics, mend_inertia)
    urdf = read_urdf(root, path.parent)
    scene = scene_of(urdf, choices, account, str(path))
    add(scene, read_additions(Path(additions)) if additions else {}, words, account)
    from flexsim_node.scene.load import SceneError, load_scene

    try:
        loaded = load_scene(scene)
    except SceneError as problem:
        raise click.ClickException(
            f"{robot}: makes no scene: {str(problem).removeprefix('scene: ')}"
        ) from None
    check_determined(scene, {joint.name: joint.where for joint in urdf.joints}, account)
    write_whole(target, scene_text(scene, str(path)))
    found: dict[str, Any] = {
        "scene": output,
        "links": len(loaded.links),
        "joints": list(loaded.joint_names),
        **{
            key.replace(" ", "_"): account.of_kind(key)
            for key in ("took", "changed", "not taken", "in doubt")
        },
        "elapsed": round(time.monotonic() - begun, 3),
    }
    if as_json:
        print_json(found)
        return
    order = ["took", "changed", "not taken", "in doubt"]
    print_table(
        f"{robot} is {output}", ["", "of", "what"],
        [line for kind in order for line in account.lines if line[0] == kind],
    )  # fmt: skip
    if not any("beam" in link for link in scene["links"]):
        say("Every link is rigid; --beam LINK=SECTION,MATERIAL makes one bend.")
