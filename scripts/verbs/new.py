"""`flexsim new`: a first scene of an arm, to be edited."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from ..terminal.output_file import OutputFile
from ..terminal.report import print_json, say

AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}


class Numbers(click.ParamType):
    """Numbers with commas between them."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return a list of floats."""
        if isinstance(value, list):
            return value
        try:
            return [float(word) for word in value.split(",")]
        except ValueError:
            self.fail(f"'{value}' is no list of numbers such as 0.5,0.4", param, ctx)


@click.command()
@click.option("-o", "--output", type=OutputFile(".yaml", ".yml"), required=True, metavar="SCENE.yaml",
              help="The scene; an existing file is kept unless --force.")  # fmt: skip
@click.option("--name", help="Of the robot; the file's if not given.")
@click.option("--axes", default="zyy", show_default=True, metavar="LETTERS",
              help="The joints from the base on, by the axes about which they turn: x, y or z.")  # fmt: skip
@click.option("--lengths", type=Numbers(), default="0.5", show_default=True,
              metavar="L1,L2,...",
              help="Of the links, m: one for all, or one each. They lie along x.")  # fmt: skip
@click.option("--beam", default="rectangle:0.02x0.02,aluminium,2", show_default=True,
              metavar="SECTION,MATERIAL[,ELEMENTS]",
              help="Of all links, as flexsim import has it.")  # fmt: skip
@click.option("--payload", type=float, default=0.0, metavar="KG", help="A point mass on the last link's end.")
@click.option("--force", is_flag=True, help="Write over an existing scene.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(output: str, name: str | None, axes: str, lengths: list[float], beam: str, payload: float,
            force: bool, as_json: bool) -> None:  # fmt: skip
    """Write a first scene: an arm of straight beams that bend, horizontal along x at the start.

    It is checked before it is written, and meant to be edited: docs/robot.md has all keys. A robot that
    exists comes with `flexsim import` instead.

    \b
    Example:
      flexsim new -o arm.yaml
      flexsim new -o arm.yaml --axes zyy --lengths 0.2,0.5,0.4 --beam tube:0.04x0.003,aluminium,3
    """
    target = Path(output)
    if not re.fullmatch("[xyz]+", axes):
        raise click.UsageError(f"--axes {axes!r}: give letters from x, y and z, such as zyy.")
    if len(lengths) not in (1, len(axes)):
        raise click.UsageError(f"--lengths has {len(lengths)} for {len(axes)} joints; give 1 or {len(axes)}.")
    if target.exists() and not force:
        raise click.ClickException(f"{target} exists already; name another file, or give --force")
    from ..robot_import.sections import beam_of
    from ..robot_import.writing import scene_text, write_whole

    try:
        keys = beam_of(beam)
    except ValueError as problem:
        raise click.UsageError(f"--beam: {problem}.") from None
    each = lengths * len(axes) if len(lengths) == 1 else lengths
    links: list[dict[str, Any]] = [
        {
            "name": f"link_{n}",
            "frame": {"xyz": [each[n - 2] if n > 1 else 0.0, 0.0, 0.0]},
            "joint": {"name": f"joint_{n}", "type": "revolute", "axis": AXES[letter]},
            "end": [length, 0.0, 0.0],
            "beam": keys,
        }
        for n, (letter, length) in enumerate(zip(axes, each, strict=True), start=1)
    ]
    if payload:
        links[-1]["payload"] = {"mass": payload}
    scene: dict[str, Any] = {"model": "robot", "name": name or target.stem, "gravity": [0.0, 0.0, -9.81]}
    scene |= {"damping": {"beta": 1e-4}, "links": links, "solver": {"step": 1e-3}}
    from flexsim_node.scene.load import SceneError, load_scene

    try:
        loaded = load_scene(scene)
    except SceneError as problem:
        raise click.ClickException(f"makes no scene: {str(problem).removeprefix('scene: ')}") from None
    write_whole(target, scene_text(scene, ""))
    if as_json:
        print_json({"scene": output, "joints": list(loaded.joint_names)})
    else:
        joints = ", ".join(loaded.joint_names)
        say(f"{output}: {len(links)} links that bend, {joints}. flexsim simulate {output}")
