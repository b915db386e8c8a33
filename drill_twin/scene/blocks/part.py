# SPDX-License-Identifier: Apache-2.0
"""Base class of a scene's parts, validation errors with a place, and fields that may be `auto`."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    model_validator,
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


Problem = tuple[tuple[str | int, ...], str]
"""Place inside the part that is checked, and message: expected and found."""


class Part(BaseModel):
    """Frozen part of a scene; unknown keys are rejected, and values that contradict each other."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if found := list(self.problems()):
            raise refuse_all(found)
        return self

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between the values of this part, each of which is valid by itself."""
        yield from ()


def refuse_all(problems: Iterable[Problem]) -> ValidationError:
    """Make a validation error of several problems, each with its place inside the part being checked."""
    return ValidationError.from_exception_data(
        "scene", [InitErrorDetails(type=refuse(text), loc=place, input=None) for place, text in problems]
    )


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
