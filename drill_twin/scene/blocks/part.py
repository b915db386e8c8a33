# SPDX-License-Identifier: Apache-2.0
"""Base class of a scene's parts, validation errors with a place, and fields that may be `auto`."""

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import InitErrorDetails, core_schema

from drill_twin.core.errors import shortened
from drill_twin.core.units import refuse


def _printable(text: str) -> str:
    if not text.isprintable():
        raise refuse(f"expected a name of printable characters on one line, found {shortened(text, 60)}")
    return text


Label = Annotated[str, Field(max_length=100), AfterValidator(_printable)]
"""Name for logs, titles and folders: no control character and no mark that reverses the text around it."""


class Part(BaseModel):
    """Frozen part of a scene; unknown keys are rejected."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def refuse_all(problems: Iterable[tuple[tuple[str | int, ...], str]]) -> ValidationError:
    """Make a validation error of several problems, each with its place inside the part being checked."""
    return ValidationError.from_exception_data(
        "scene", [InitErrorDetails(type=refuse(text), loc=place, input=None) for place, text in problems]
    )


def refuse_at(place: tuple[str | int, ...], message: str) -> ValidationError:
    """Make a validation error at a place inside the part being checked."""
    return refuse_all([(place, message)])


class OrAuto:
    """Annotation of a field whose value may be the word `auto`."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        def check(value: Any, inner: core_schema.ValidatorFunctionWrapHandler) -> Any:
            return value if value == "auto" else inner(value)

        return core_schema.no_info_wrap_validator_function(check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"const": "auto"}, handler(schema)]}
