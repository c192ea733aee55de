"""Scenes' keys as JSON Schema, for editors: from the same models that check the scenes."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue

DIALECT = "https://json-schema.org/draft/2020-12/schema"
SHORT = {"not": {"type": "object"}}


class _Keys(GenerateJsonSchema):
    """JSON Schema in which a part with a short form may be anything but a mapping with other keys."""

    def function_before_schema(self, schema: Any) -> JsonSchemaValue:
        """What is checked beforehand may be written otherwise, but for numbers and a part's own fields."""
        inner = self.generate_inner(schema["schema"])
        plain = schema["schema"]["type"] in ("float", "int", "model-fields")
        return inner if plain else {"anyOf": [inner, SHORT]}

    def model_schema(self, schema: Any) -> JsonSchemaValue:
        """A part's fields; of parts that read a short form also that."""
        found = super().model_schema(schema)
        short = schema["schema"]["type"] == "function-before"
        whole = "model" in found["properties"]  # a scene is always a mapping
        return {"anyOf": [found, SHORT]} if short and not whole else found


def json_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a model of scenes; a key that it does not know is invalid.

    Relations between keys (a beam needs a length) are not in it: reading a scene checks them.
    """
    found = model.model_json_schema(schema_generator=_Keys, mode="validation")
    return {"$schema": DIALECT, **found, "title": title}
