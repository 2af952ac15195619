"""JSON Schemas of the payloads, in the subset that stock viewers can read.

Viewers turn a ``jsonschema`` record into a message definition. They require an object at the top,
no references, no unions, and properties on every object; a schema outside that subset makes the
whole topic unreadable. An optional field may be absent, but never null.
"""

from __future__ import annotations

from typing import Any

import msgspec


def viewer_schema(payload_type: type[msgspec.Struct], title: str) -> dict[str, Any]:
    """Return the JSON Schema of a struct, references inlined, named ``title``."""
    (root,), definitions = msgspec.json.schema_components([payload_type])
    return {**_inlined(root, definitions), "title": title}


def _inlined(schema: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """Replace references by their definitions and ``X or null`` by X, at every depth."""
    schema = _resolved(schema, definitions)
    if "properties" in schema:
        properties = schema["properties"].items()
        schema["properties"] = {name: _inlined(part, definitions) for name, part in properties}
    elif schema.get("type") == "object":
        schema["properties"] = {}  # a table with keys of its own
    elif "enum" in schema:
        schema["type"] = "string"
    if isinstance(schema.get("items"), dict):
        schema["items"] = _inlined(schema["items"], definitions)
    return schema


def _resolved(schema: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """Follow one reference and one optional, keeping the description given beside them."""
    beside = {key: value for key, value in schema.items() if key == "description"}
    if "anyOf" in schema:
        (present,) = (part for part in schema["anyOf"] if part.get("type") != "null")
        return _resolved({**present, **beside}, definitions)
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return {**definitions[name], **beside}
    return {key: value for key, value in schema.items() if key != "default"}
