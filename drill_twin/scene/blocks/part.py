# SPDX-License-Identifier: Apache-2.0
"""Base class of a scene's parts, and validation errors with a place."""

from collections.abc import Iterable
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import InitErrorDetails

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
