# SPDX-License-Identifier: Apache-2.0
"""Messages for pydantic's validation errors: place, expected, found, nearest valid name."""

import inspect
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from drill_twin.core.errors import SceneError, nearest
from drill_twin.core.files.yaml_reader import Place
from drill_twin.core.units import Quantity, show
from drill_twin.physics.effects import LEFT_OUT
from drill_twin.scene.lines import Lines

_MOST_EXPLAINED = 100
"""Number of problems that are put into words; further problems are counted."""


def scene_error(found: list[ErrorDetails], lines: Lines, model: type[BaseModel]) -> SceneError:
    """Error with all problems; its message has the first one in the file and the number of others."""
    around = {detail["loc"][:length] for detail in found for length in range(len(detail["loc"]))}
    causes = [detail for detail in found if detail["loc"] not in around]  # a list is short as its item is invalid
    details = sorted(causes, key=lambda detail: (detail["type"] == "missing", lines.order(detail["loc"])))
    messages = tuple(dict.fromkeys(_message(detail, lines, model) for detail in details[:_MOST_EXPLAINED]))
    more = len(messages) - 1 + len(details[_MOST_EXPLAINED:])
    rest = f" (and {more} more {'problem' if more == 1 else 'problems'}: see `drill-twin scene check`)" if more else ""
    result = SceneError(messages[0] + rest)
    result.problems = messages
    return result


def path_text(path: Place) -> str:
    """Text of a place in the data: `string.sections[0].length`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def _message(detail: ErrorDetails, lines: Lines, model: type[BaseModel]) -> str:
    place = detail["loc"]
    heir = f" (inherited by {lines.heir(place)})" if lines.heir(place) else ""
    return f"{lines.where(place)}: {path_text(place)}: {_explanation(detail, place, model)}{heir}"


def _explanation(detail: ErrorDetails, place: Place, model: type[BaseModel]) -> str:
    kind, found, context = detail["type"], detail["input"], detail.get("ctx", {})
    if kind == "drill_twin":
        return str(context["message"])
    if kind == "extra_forbidden":
        known = _keys(model, place[:-1])
        key = str(place[-1])
        if len(place) == 2 and place[0] == "effects" and key in LEFT_OUT:
            return f'expected an effect that can be run, found "{key}", which is left out: {LEFT_OUT[key]}'
        effects = _keys(model, ("effects",)) if len(place) == 1 else []
        within = [f"effects.{one}" for one in effects if one == key]
        within += [f"effects.{one}.{key}" for one in effects if key in _keys(model, ("effects", one))]
        near = nearest(key, [*known, *(f"effects.{one}" for one in effects)])
        hint = f", did you mean {' or '.join(within)}?" if within else near
        return f'expected one of the keys {", ".join(known)}, found "{key}"{hint}'
    if kind == "missing":
        return f"expected {_expected(model, place)}, found nothing (the key is required)"
    if kind == "literal_error":
        known = [word.strip("'") for word in str(context["expected"]).replace(" or ", ", ").split(", ")]
        return f"expected one of {', '.join(known)}, found {show(found)}{nearest(str(found), known)}"
    if kind in {"model_type", "model_attributes_type", "dict_type"}:
        return f"expected a block with the keys {', '.join(_keys(model, place))}, found {show(found)}"
    if kind in {"tuple_type", "list_type"}:
        return f"expected a list, each item in a line that begins with `- `, found {show(found)}"
    if kind == "string_type":
        return f"expected text, found {show(found)}"
    if kind == "string_pattern_mismatch":
        return f"expected letters, digits and underscores, a letter first, found {show(found)}"
    if kind in {"too_short", "too_long"}:
        side, size = ("least", context.get("min_length")) if kind == "too_short" else ("most", context["max_length"])
        return f"expected at {side} {size} item{'s' * (size != 1)}, found {context['actual_length'] or 'none'}"
    if kind == "string_too_short":
        return "expected text, found none"
    return f"expected another value ({detail['msg']}), found {show(found)}"


def _expected(model: type[BaseModel], place: Place) -> str:
    field = _followed(model, place)[0]
    for part in field.metadata if field else ():
        if isinstance(part, Quantity):
            return part.dimension.expected
    annotation = field.annotation if field else None
    inside = _model(annotation)
    if inside:
        what = "a list of blocks" if get_origin(annotation) is tuple else "a block"
        return f"{what} with the keys {', '.join(inside.model_fields)}"
    return "text" if annotation is str else "a value"


def _keys(model: type[BaseModel], place: Place) -> list[str]:
    """Valid keys of the block at a place."""
    inside = _followed(model, place)[1]
    return list(inside.model_fields) if inside else []


def _followed(model: type[BaseModel], place: Place) -> tuple[FieldInfo | None, type[BaseModel] | None]:
    """Field at a place, and the block in it."""
    inside: type[BaseModel] | None = model
    field: FieldInfo | None = None
    for part in place:
        if isinstance(part, str):
            field = inside.model_fields.get(part) if inside else None
            inside = _model(field.annotation) if field else None
    return field, inside


def _model(annotation: Any) -> type[BaseModel] | None:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := _model(part))), None)
