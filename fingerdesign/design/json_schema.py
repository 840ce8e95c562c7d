"""JSON schemas of design and scene files, from which editors complete and explain keys.

``python -m fingerdesign.design.json_schema`` writes the shipped copies anew.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design

DATA = Path(__file__).resolve().parent.parent / "data"


def design_json_schema() -> dict[str, Any]:
    """Return the JSON schema of a design file."""
    return _schema(Design, "A finger design (fingerdesign)")


def scene_json_schema() -> dict[str, Any]:
    """Return the JSON schema of a scene file."""
    return _schema(Scene, "A scene that a finger is put through (fingerdesign)")


def schema_text(schema: dict[str, Any]) -> str:
    """Write a schema the way it is shipped."""
    return json.dumps(schema, indent=2) + "\n"


def _schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    schema = model.model_json_schema(mode="validation")
    # Known materials fill in what a file leaves out; which names are known, the schema can't say.
    schema.get("$defs", {}).get("Material", {}).pop("required", None)
    dialect = "https://json-schema.org/draft/2020-12/schema"
    simplified: dict[str, Any] = _without_null(schema)
    return {"$schema": dialect, **simplified, "title": title}


def _without_null(node: Any) -> Any:
    """Drop the null that pydantic allows for absent keys: TOML cannot write it."""
    if isinstance(node, list):
        return [_without_null(item) for item in node]
    if not isinstance(node, dict):
        return node
    node = {key: _without_null(item) for key, item in node.items()}
    choices = node.get("anyOf")
    if isinstance(choices, list) and {"type": "null"} in choices:
        rest = [choice for choice in choices if choice != {"type": "null"}]
        del node["anyOf"]
        if node.get("default", 0) is None:
            del node["default"]
        return {**node, **rest[0]} if len(rest) == 1 else {**node, "anyOf": rest}
    return node


def write_schemas(folder: Path = DATA) -> None:
    """Write both schemas into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "design.schema.json").write_text(schema_text(design_json_schema()), "utf-8")
    (folder / "scene.schema.json").write_text(schema_text(scene_json_schema()), "utf-8")


if __name__ == "__main__":
    write_schemas()
