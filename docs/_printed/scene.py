# SPDX-License-Identifier: Apache-2.0
"""Keys of a scene file and of its effects, from the JSON Schema of the scene models."""

import re
from functools import cache
from typing import Any

from _printed.markdown import code, table
from drill_twin.physics.effects import EFFECTS
from drill_twin.scene.json_schema import scene_json_schema

Block = dict[str, Any]


@cache
def _schema() -> Block:
    return scene_json_schema()


def scene_keys() -> str:
    """A section for each block of a scene, in the order of a file; the effects are on a page of their own."""
    blocks, queue = [_section("", _schema()["else"])], list(_blocks("", _schema()["else"]))
    while queue:
        path, block = queue.pop(0)
        if path == "effects":
            continue
        blocks.append(_section(path, block))
        queue[:0] = _blocks(path, block)
    return "\n".join(blocks)


def effect_keys() -> str:
    """A section for each effect."""
    definitions = _schema()["definitions"]
    parts = []
    for key, config in EFFECTS.items():
        block = definitions[config.__name__]
        text = f"## {key}\n\n{_prose(block['description'])}\n"
        if config.requires:
            text += f"\nNeeds {', '.join(code(other) for other in config.requires)}.\n"
        parts.append(text + (f"\n{_keys(block)}" if block["properties"] else "\nIt has no keys.\n"))
    return "\n".join(parts)


def _section(path: str, block: Block) -> str:
    title = f"## {path}" if path else "## The file"
    description = _prose(block.get("description", "The blocks of a scene file."))
    return f"{title}\n\n{description}\n\n{_keys(block)}"


def _blocks(path: str, block: Block) -> list[tuple[str, Block]]:
    """Blocks in a block, with their paths; an item of a list is `[k]`."""
    found = []
    for key, field in block["properties"].items():
        for part in (field, *field.get("anyOf", ())):
            item = part.get("items", part)
            if name := str(item.get("$ref", "")).rpartition("/")[2]:
                place = f"{path}.{key}".strip(".") + ("[k]" if "items" in part else "")
                found.append((place, _schema()["definitions"][name]))
    return found


def _keys(block: Block) -> str:
    required = block.get("required", ())
    rows = (
        (code(key), _expected(field), _default(field, required=key in required), _prose(field.get("description", "")))
        for key, field in block["properties"].items()
    )
    return table(("key", "expected", "default", "meaning and range"), rows)


def _expected(field: Block) -> str:
    """Kind of value, in words."""
    parts = field.get("anyOf", [field])
    return " or ".join(dict.fromkeys(text for part in parts for text in _kinds(part)))


def _kinds(part: Block) -> list[str]:
    if "anyOf" in part:
        return [kind for inner in part["anyOf"] for kind in _kinds(inner)]
    if "$ref" in part:
        return ["a block"]
    if "enum" in part:
        return [code(str(value)) for value in part["enum"]]
    if "const" in part:
        return [code(str(part["const"]))]
    if "examples" in part:
        return [f"a quantity such as {code(part['examples'][0])}"]
    words = {"integer": "a whole number", "number": "a number", "boolean": "true or false", "array": "a list",
             "string": "a text", "object": "a block"}  # fmt: skip
    kind = part.get("type")
    kinds = kind if isinstance(kind, list) else [kind]
    texts = [words[name] for name in kinds if name in words]
    if part.get("type") in {"integer", "number"} and "minimum" in part and "maximum" in part:
        low, high = part["minimum"], part["maximum"]
        texts = [f"{texts[0]} from {low:g} to {high:g}"] if high < 1e15 else texts
    return texts


def _default(field: Block, *, required: bool) -> str:
    if required:
        return "required"
    value = field.get("default")
    if value is None or value in ([], ""):
        return ""
    return code(str(value).lower() if isinstance(value, bool) else str(value))


def _prose(text: str) -> str:
    """Docstring with a line for each paragraph; outside of code, an asterisk of a product is no emphasis."""
    paragraphs = [" ".join(part.split()) for part in text.split("\n\n")]
    spans = re.split(r"(`[^`]*`)", "\n\n".join(paragraphs))
    return "".join(span if span.startswith("`") else re.sub(r"([*_<|])", r"\\\1", span) for span in spans)
