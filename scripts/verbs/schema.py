"""`flexsim schema`: the keys of scenes as JSON Schema, for editors."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command()
@click.argument("kind", type=click.Choice(["robot", "door"]))
@click.option("-o", "--output", type=click.Path(dir_okay=False), metavar="FILE.json",
              help="Where to write it, over what is there; printed if not given.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="JSON Schema is JSON: changes nothing.")
def command(kind: str, output: str | None, as_json: bool) -> None:
    """Print the keys, types and ranges of a robot's or a door's scene as JSON Schema.

    An editor with it completes keys and marks unknown ones: VS Code's YAML takes it from a scene's first
    line, "# yaml-language-server: $schema=robot.schema.json". What several keys say together is checked
    when the scene is read.

    \b
    Example:
      flexsim schema robot -o robot.schema.json
    """
    from flexsim_core.json_schema import json_schema

    if kind == "robot":
        from flexsim_node.scene.schema import Scene as Robot

        found = json_schema(Robot, "A robot's scene")
    else:
        from thermal_node.scene.schema import Scene as Door

        found = json_schema(Door, "A door's scene")
    text = json.dumps(found, indent=2)
    if output is None:
        click.echo(text)
    else:
        Path(output).write_text(text + "\n", encoding="utf-8")
