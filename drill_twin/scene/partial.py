# SPDX-License-Identifier: Apache-2.0
"""Contradictions between the valid parts of a scene that has invalid ones, so that one check shows all problems."""

from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from drill_twin.scene.blocks.effects import Effects
from drill_twin.scene.blocks.hole import Hole
from drill_twin.scene.blocks.part import refuse_all
from drill_twin.scene.blocks.rig import Rig
from drill_twin.scene.blocks.string import String
from drill_twin.scene.check import UnknownPart, UnknownPartError, contradictions
from drill_twin.scene.schema import Scene


def contradictions_of_valid_parts(data: dict[str, Any], *, text: bool) -> list[ErrorDetails]:
    """Find the contradictions that an invalid part would hide, as pydantic checks a whole with valid parts only.

    Args:
        data: The scene's data.
        text: True if a number without a unit is invalid.
    """
    parts: dict[str, type[BaseModel]] = {"string": String, "hole": Hole, "rig": Rig}
    valid: dict[str, Any] = {key: _valid(kind, data.get(key), text) for key, kind in parts.items()}
    scene = Scene.model_construct(effects=_valid_effects(data.get("effects"), text), **valid)
    found = list(contradictions(scene))
    return refuse_all(found).errors(include_url=False) if found else []


def _valid(kind: type[BaseModel], data: Any, text: bool) -> Any:
    try:
        return kind.model_validate(data, context={"text": text})
    except ValidationError:
        return UnknownPart()


def _valid_effects(data: Any, text: bool) -> Any:
    """Effects of the valid blocks; an invalid block raises UnknownPartError when asked for."""
    if not isinstance(data, dict):
        return UnknownPart()
    known = {key: block for key, block in data.items() if key in Effects.model_fields}
    invalid = {key for key, block in known.items() if isinstance(_valid(Effects, {key: block}, text), UnknownPart)}
    valid = Effects.model_validate(
        {key: block for key, block in known.items() if key not in invalid}, context={"text": text}
    )
    return _ValidEffects(valid, invalid)


class _ValidEffects:
    def __init__(self, valid: Effects, invalid: set[str]) -> None:
        self._valid, self._invalid = valid, invalid

    def __getattr__(self, name: str) -> Any:
        if name in self._invalid:
            raise UnknownPartError(name)
        return getattr(self._valid, name)
