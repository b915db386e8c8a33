# SPDX-License-Identifier: Apache-2.0
"""What every part of a scene has in common, and how a check names the place that is wrong."""

from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import InitErrorDetails

from drill_twin.units import refuse


class Part(BaseModel):
    """A frozen part of a scene; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def refuse_at(place: tuple[str | int, ...], message: str, found: Any = None) -> ValidationError:
    """A validation error at a place inside the part that is being checked."""
    return ValidationError.from_exception_data(
        "scene", [InitErrorDetails(type=refuse(message), loc=place, input=found)]
    )
