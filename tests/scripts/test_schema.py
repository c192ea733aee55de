"""`flexsim schema`: JSON Schema takes every scene of config/, and no key that a scene has not."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim
from ruamel.yaml import YAML

CONFIG = Path(__file__).parents[2] / "config"
SCENES = {path.name: YAML(typ="safe").load(path) for path in sorted(CONFIG.glob("*.yaml"))}
SCENES = {name: scene for name, scene in SCENES.items() if "model" in scene}
BY_NAME = {("materials",), ("initial", "position"), ("initial", "velocity")}  # whose keys are names
SAID = {
    "$schema",
    "$defs",
    "title",
    "description",
    "default",
    "discriminator",
}  # what a validator passes over
TYPES = {
    "object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), "integer": int,
    "number": (int, float),
}  # fmt: skip
CHECKED = {
    "$ref", "anyOf", "not", "type", "properties", "required", "additionalProperties", "items", "prefixItems",
    "minItems", "maxItems", "enum", "const", "minimum", "maximum", "exclusiveMinimum", "pattern", "minLength",
    "oneOf", "propertyNames",
}  # fmt: skip


def valid(value: Any, rule: Any, whole: dict) -> bool:
    """Whether a value keeps to a schema, by the keywords that ours have."""
    if isinstance(rule, bool):
        return rule
    assert set(rule) <= SAID | CHECKED, set(rule) - SAID - CHECKED
    if "$ref" in rule and not valid(value, whole["$defs"][rule["$ref"].rpartition("/")[2]], whole):
        return False
    if "anyOf" in rule and not any(valid(value, branch, whole) for branch in rule["anyOf"]):
        return False
    if "oneOf" in rule and sum(valid(value, branch, whole) for branch in rule["oneOf"]) != 1:
        return False
    if "not" in rule and valid(value, rule["not"], whole):
        return False
    if "type" in rule:
        number = rule["type"] in ("integer", "number") and isinstance(value, bool)
        if number or not isinstance(value, TYPES[rule["type"]]):
            return False
    if value not in rule.get("enum", [value]) or value != rule.get("const", value):
        return False
    if isinstance(value, dict):
        known, others = rule.get("properties", {}), rule.get("additionalProperties", True)
        names = all(valid(key, rule.get("propertyNames", True), whole) for key in value)
        return (
            names
            and all(key in value for key in rule.get("required", []))
            and all(valid(inside, known.get(key, others), whole) for key, inside in value.items())
        )
    if isinstance(value, list):
        first, others = rule.get("prefixItems", []), rule.get("items", True)
        return rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", len(value)) and all(
            valid(inside, first[n] if n < len(first) else others, whole) for n, inside in enumerate(value)
        )
    if isinstance(value, str):
        return len(value) >= rule.get("minLength", 0) and bool(re.search(rule.get("pattern", ""), value))
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        least = rule.get("minimum", value) <= value <= rule.get("maximum", value)
        return least and not value <= rule.get("exclusiveMinimum", value - 1.0)
    return True


def mappings(value: Any, path: tuple = ()) -> Iterator[tuple[tuple, dict]]:
    """All mappings in a document, and where."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    if isinstance(value, dict):
        yield path, value
    for key, below in inside:
        yield from mappings(below, (*path, key))


@pytest.fixture(scope="module")
def schemas() -> dict[str, dict]:
    """What the command prints."""
    found = {}
    for kind in ("robot", "door"):
        done = CliRunner().invoke(flexsim, ["schema", kind])
        assert done.exit_code == 0
        found[kind] = json.loads(done.output)
    return found


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_valid(schemas, name):
    """Every scene of config/ is valid; with a key more anywhere it is not."""
    scene = copy.deepcopy(SCENES[name])
    schema = schemas["robot" if scene["model"] == "robot" else "door"]
    assert valid(scene, schema, schema)
    for path, mapping in list(mappings(scene)):
        mapping["no_such_key"] = 1
        assert valid(scene, schema, schema) == (path in BY_NAME), path
        del mapping["no_such_key"]


LINK = {"name": "a", "dh": {"a": 0.5}}


@pytest.mark.parametrize(
    ("keys", "right"),
    [
        ({}, True),
        ({"effects": "auto"}, True),
        ({"effects": {"shear": "auto"}}, True),
        ({"effects": {"shear": "maybe"}}, False),
        ({"validity": {"elastic_rotation": {"warn": 0.2}}}, True),
        ({"solver": {"step": 0.0}}, False),
        ({"solver": {"step": 2.0}}, False),
        ({"solver": {"method": "euler"}}, False),
        ({"duration": "1 s"}, False),
        ({"gravity": [0, -9.81]}, False),
        ({"links": []}, False),
        ({"links": [LINK | {"frame": {"xyz": [0, 0, 300.0]}}]}, False),
        ({"links": [LINK | {"frame": {"xyz": [0, 0, 0.3]}, "points": {"tool": [0, 0, 1]}}]}, True),
    ],
)
def test_keys_of_robots(schemas, keys, right):
    """Types, choices and ranges are in it, and short forms."""
    scene = {"model": "robot", "name": "r", "links": [LINK]} | keys
    assert valid(scene, schemas["robot"], schemas["robot"]) == right


def test_written(schemas, tmp_path):
    """To a file, as it is printed."""
    path = tmp_path / "door.json"
    assert CliRunner().invoke(flexsim, ["schema", "door", "-o", str(path)]).exit_code == 0
    assert json.loads(path.read_text()) == schemas["door"]
    assert CliRunner().invoke(flexsim, ["schema", "roof"]).exit_code == 2
