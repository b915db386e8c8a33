# SPDX-License-Identifier: Apache-2.0
"""JSON Schema of scene files, for completion and checks in editors.

It is exported to `config/schema/scene.schema.json`, to which the first line of a scene points (yaml-language-server).
"""

import ast
import inspect
import json
import textwrap
from contextlib import suppress
from itertools import pairwise
from typing import Any, get_args

from pydantic import BaseModel

from drill_twin.scene.blocks.rig import SetPoint
from drill_twin.scene.schema import Scene


def scene_json_schema() -> dict[str, Any]:
    """The schema (draft 7, best supported by editors): units checked, ranges and defaults in the descriptions."""
    schema = Scene.model_json_schema(ref_template="#/definitions/{model}")
    for model in _models(Scene):
        block = schema if model is Scene else schema["$defs"][model.__name__]
        for key, text in descriptions(model).items():
            if key in block["properties"]:
                block["properties"][key]["description"] = text
    schema = _readable(schema)
    definitions = schema.pop("$defs")
    for set_point in SetPoint.__subclasses__():
        definitions[set_point.__name__].update(_VALUE_UNLESS_TABLE)
    definitions["Effects"]["properties"] = {
        key: _on_off_or_block(field) for key, field in definitions["Effects"]["properties"].items()
    }
    definitions["Effects"]["required"] = ["stretch", "torsion"]
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "drill_twin scene",
        "description": schema.pop("description"),
        "if": {"required": ["base"]},
        "then": {"properties": {"base": _BASE}},
        "else": {key: value for key, value in schema.items() if key != "title"},
        "definitions": definitions,
    }


def schema_text() -> str:
    """Text of the exported schema file."""
    return json.dumps(scene_json_schema(), indent=2, ensure_ascii=False, sort_keys=True) + "\n"


def _models(annotation: Any) -> set[type[BaseModel]]:
    """Models in an annotation and, recursively, in their fields."""
    if not (inspect.isclass(annotation) and issubclass(annotation, BaseModel)):
        return set().union(*(_models(part) for part in get_args(annotation)))
    return {annotation}.union(*(_models(field.annotation) for field in annotation.model_fields.values()))


_BASE = {
    "type": "string",
    "description": "Scene (a name, or a path from this file's folder) on which this one is based: only differences are "
    "written, lists in full; `value: ~` removes a key of the base.",
}
_VALUE_UNLESS_TABLE = {
    "if": {"properties": {"shape": {"const": "table"}}, "required": ["shape"]},
    "else": {"required": ["value"]},
}


def _on_off_or_block(field: dict[str, Any]) -> dict[str, Any]:
    """Schema of an effect's key: a block, nothing (the effect with its defaults), or `off`."""
    reference = next(part for part in field["anyOf"] if "$ref" in part)
    return {"description": field["description"], "anyOf": [reference, {"type": ["null", "boolean"]}]}


def _readable(node: Any) -> Any:
    """Remove titles, write defaults with units, append ranges to the descriptions."""
    if isinstance(node, list):
        return [_readable(item) for item in node]
    if not isinstance(node, dict):
        return node
    result = {key: _readable(value) for key, value in node.items() if not (key == "title" and isinstance(value, str))}
    if len(result.get("allOf", ())) == 1:  # older releases of pydantic wrap a reference that has a description
        result.update(result.pop("allOf")[0])
    if "const" in result:  # they also repeat a single choice as `enum`
        result.pop("enum", None)
    unit, limits = result.pop("x-unit", None), result.pop("x-range", "")
    for branch in result.get("anyOf", ()):
        if isinstance(branch, dict):
            unit, limits = branch.pop("x-unit", unit), branch.pop("x-range", limits)
    if unit and isinstance(result.get("default"), float):
        result["default"] = f"{result['default']:.12g} {unit}"
    if isinstance(result.get("default"), dict):
        del result["default"]
    if limits and "description" in result:
        result["description"] += f" Range: {limits}."
    return result


def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Docstring of each field on one line, by its name, the fields of the base classes included.

    pydantic can collect them (`use_attribute_docstrings`), but does so at import, which takes each node 0.08 s.
    """
    found: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if base is BaseModel or not issubclass(base, BaseModel):
            continue
        with suppress(OSError):  # a class made by `create_model` has no source, but descriptions in its fields
            (definition,) = ast.parse(textwrap.dedent(inspect.getsource(base))).body
            for pair in pairwise(getattr(definition, "body", ())):
                match pair:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=text):
                        found[name] = " ".join(str(ast.literal_eval(text)).split())
    return found
