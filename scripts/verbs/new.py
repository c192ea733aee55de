"""`flexsim new`: a first scene of an arm or of a fire door, to be edited."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from ..terminal.output_file import OutputFile
from ..terminal.report import print_json, say

AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}


class Words(click.ParamType):
    """Words that a function reads; what it raises as ValueError is said, and asked for again."""

    def __init__(self, name: str, read: Callable[[str], Any]) -> None:
        self.name, self.read = name, read

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return what the words mean."""
        if not isinstance(value, str):
            return value
        try:
            return self.read(value.strip())
        except ValueError as problem:
            self.fail(str(problem), param, ctx)


def letters(words: str) -> str:
    """Axes of joints."""
    if not re.fullmatch("[xyz]+", words):
        raise ValueError(f"'{words}': give letters from x, y and z, such as zyy")
    return words


def numbers(words: str) -> list[float]:
    """Numbers with commas between them."""
    try:
        return [float(word) for word in words.split(",")]
    except ValueError:
        raise ValueError(f"'{words}' is no list of numbers such as 0.5,0.4") from None


def section(words: str) -> dict[str, Any]:
    """A beam in words, as flexsim import has it."""
    from ..robot_import.sections import beam_of

    return beam_of(words)


def size(words: str) -> tuple[float, float]:
    """Width and height."""
    parts = words.split("x")
    try:
        width, height = (float(part) for part in parts)
    except ValueError:
        raise ValueError(f"'{words}' is no size such as 1.0x2.1, width and height in m") from None
    return width, height


def layers(words: str) -> list[dict[str, Any]]:
    """Layers of a leaf, from the fire on."""
    found = []
    for part in words.split(","):
        material, _, thickness = part.strip().partition(":")
        try:
            found.append({"material": material, "thickness": float(thickness)})
        except ValueError:
            raise ValueError(f"'{part}' is no layer such as stone_wool_100:0.05, in m") from None
    return found


@click.command()
@click.argument("kind", type=click.Choice(["robot", "door"]), default="robot")
@click.option("-o", "--output", type=OutputFile(".yaml", ".yml"), metavar="SCENE.yaml",
              help="The scene; an existing file is kept unless --force.")  # fmt: skip
@click.option("--ask", is_flag=True, help="Ask for all that is not given.")
@click.option("--name", help="Of the robot or door; the file's if not given.")
@click.option("--axes", type=Words("axes", letters), default="zyy", show_default=True, metavar="LETTERS",
              help="Of a robot: the axes, x, y or z, that its joints turn about, in order.")  # fmt: skip
@click.option("--lengths", type=Words("numbers", numbers), default="0.5", show_default=True,
              metavar="L1,L2,...",
              help="Of its links, m: one for all, or one each. They lie along x.")  # fmt: skip
@click.option("--beam", type=Words("beam", section), default="rectangle:0.02x0.02,aluminium,2",
              show_default=True, metavar="SECTION,MATERIAL[,ELEMENTS]",
              help="Of all its links, as flexsim import has it.")  # fmt: skip
@click.option("--payload", type=float, default=0.0, show_default=True, metavar="KG",
              help="A point mass on its last link's end.")  # fmt: skip
@click.option("--size", type=Words("size", size), default="1.0x2.1", show_default=True,
              metavar="WIDTHxHEIGHT", help="Of a door's leaf, m.")  # fmt: skip
@click.option("--layers", type=Words("layers", layers), show_default=True,
              default="steel:0.0015,stone_wool_100:0.05,steel:0.0015", metavar="MATERIAL:THICKNESS,...",
              help="Of its leaf, from the fire on, m: materials of docs/materials.md.")  # fmt: skip
@click.option("--minutes", type=click.IntRange(1), default=60, show_default=True,
              help="That it is to resist fire, by EN 1634-1.")  # fmt: skip
@click.option("--force", is_flag=True, help="Write over an existing scene.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.pass_context
def command(ctx: click.Context, kind: str, output: str | None, ask: bool, name: str | None, force: bool,
            as_json: bool, **flags: Any) -> None:  # fmt: skip
    """Write a first scene: an arm of straight beams that bend, horizontal, or a door in its furnace.

    It is checked before it is written, and meant to be edited: docs/robot.md and docs/door.md have all keys.
    A robot that exists comes with `flexsim import` instead.

    \b
    Example:
      flexsim new -o arm.yaml
      flexsim new -o arm.yaml --axes zyy --lengths 0.2,0.5,0.4 --beam tube:0.04x0.003,aluminium,3
      flexsim new door -o door.yaml --layers steel:0.001,stone_wool_100:0.06,steel:0.001
      flexsim new --ask
    """
    own = ROBOT if kind == "robot" else DOOR
    for flag in flags:
        if flag not in own and given(ctx, flag):
            raise click.UsageError(f"--{flag} is not of a {kind}.")
    if ask:
        if not given(ctx, "kind"):
            kind = click.prompt("robot or door", default=kind, type=click.Choice(["robot", "door"]), err=True)
            own = ROBOT if kind == "robot" else DOOR
        output = answer(ctx, "output", f"{'arm' if kind == 'robot' else 'door'}.yaml")
        flags |= {flag: answer(ctx, flag) for flag in own}
    if output is None:
        raise click.UsageError("Missing option '-o': give the scene's file, or --ask.")
    target = Path(output)
    if target.exists() and not force:
        raise click.ClickException(f"{target} exists already; name another file, or give --force")
    made = {flag: flags[flag] for flag in own}
    about = robot(name or target.stem, **made) if kind == "robot" else door(name or target.stem, **made)
    from ..robot_import.writing import scene_text, write_whole

    said = check(about)
    write_whole(target, scene_text(about) if kind == "robot" else scene_text(about, units=DOOR_UNITS))
    if as_json:
        print_json({"scene": output, **said})
    elif kind == "robot":
        joints = ", ".join(said["joints"])
        say(f"{output}: {len(about['links'])} links that bend, {joints}. flexsim simulate {output}")
    else:
        say(f"{output}: a leaf of {len(said['layers'])} layers. flexsim door simulate {output}")


ROBOT = ("axes", "lengths", "beam", "payload")
DOOR = ("size", "layers", "minutes")
DOOR_UNITS = "Lengths in m, temperatures in C, times in s."


def given(ctx: click.Context, flag: str) -> bool:
    """Whether a flag stands in the command line."""
    return ctx.get_parameter_source(flag) is ParameterSource.COMMANDLINE


def answer(ctx: click.Context, flag: str, default: str | None = None) -> Any:
    """What a person answers to a flag's question, unless the flag is given."""
    if given(ctx, flag):
        return ctx.params[flag]
    option = next(p for p in ctx.command.params if isinstance(p, click.Option) and p.name == flag)
    words = (option.help or flag).rstrip(".")
    return click.prompt(words, default=default or option.default, type=option.type, err=True)


def check(scene: dict[str, Any]) -> dict[str, Any]:
    """Read the scene as a program would; returns the names in it."""
    if scene["model"] == "robot":
        from flexsim_node.scene.load import SceneError, load_scene

        try:
            return {"joints": list(load_scene(scene).joint_names)}
        except SceneError as problem:
            reason = str(problem)
    else:
        from thermal_node.scene.load import SceneError as DoorError
        from thermal_node.scene.load import load_scene as load_door

        try:
            return {"layers": [layer.material for layer in load_door(scene).leaf.layers]}
        except DoorError as problem:
            reason = str(problem)
    raise click.ClickException(f"makes no scene: {reason.removeprefix('scene: ')}")


def robot(name: str, axes: str, lengths: list[float], beam: dict[str, Any], payload: float) -> dict[str, Any]:
    """An arm along x."""
    if len(lengths) not in (1, len(axes)):
        raise click.UsageError(f"--lengths has {len(lengths)} for {len(axes)} joints; give 1 or {len(axes)}.")
    each = lengths * len(axes) if len(lengths) == 1 else lengths
    links: list[dict[str, Any]] = [
        {
            "name": f"link_{n}",
            "frame": {"xyz": [each[n - 2] if n > 1 else 0.0, 0.0, 0.0]},
            "joint": {"name": f"joint_{n}", "type": "revolute", "axis": AXES[letter]},
            "end": [length, 0.0, 0.0],
            "beam": beam,
        }
        for n, (letter, length) in enumerate(zip(axes, each, strict=True), start=1)
    ]
    if payload:
        links[-1]["payload"] = {"mass": payload}
    scene: dict[str, Any] = {"model": "robot", "name": name, "gravity": [0.0, 0.0, -9.81]}
    return scene | {"damping": {"beta": 1e-4}, "links": links, "solver": {"step": 1e-3}}


def door(name: str, size: tuple[float, float], layers: list[dict[str, Any]], minutes: int) -> dict[str, Any]:
    """A leaf in a furnace that follows ISO 834, judged by EN 1634-1."""
    return {
        "model": "fire_door",
        "name": name,
        "leaf": {"height": size[1], "width": size[0], "layers": layers},
        "furnace": {"curve": "iso_834"},
        "solver": {"model": "column"},
        "criteria": {"standard": "en_1634", "minutes": minutes},
    }
