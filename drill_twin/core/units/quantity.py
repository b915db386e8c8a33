# SPDX-License-Identifier: Apache-2.0
"""Annotations of pydantic fields that read `"40 N"` and hold 40.0: floats in SI inside, text with its unit in files.

A scene file must write the unit; a bare number is refused there (validation context `{"text": True}`). Code may pass
plain floats, which are SI.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import PydanticCustomError, core_schema

from drill_twin.core.units.dimension import DIMENSIONLESS, Dimension
from drill_twin.core.units.parse import editor_pattern, parse, short, write
from drill_twin.core.units.registry import UnitError


def refuse(message: str) -> PydanticCustomError:
    """Make a validation error with a message."""
    return PydanticCustomError("drill_twin", "{message}", {"message": message})


def show(value: object) -> str:
    """Quote a found value for a message, on one short line."""
    if value is None:
        return "nothing"
    return f'"{short(value)}"' if isinstance(value, str) else short(repr(value))


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float field with its dimension."""

    dimension: Dimension

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Parse with the dimension; write with the SI unit in JSON mode, as a float in Python mode."""
        return core_schema.with_info_plain_validator_function(
            self._read,
            serialization=core_schema.plain_serializer_function_ser_schema(self._write, when_used="json"),
            metadata={"dimension": self.dimension},
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Pattern, examples and unit for editors."""
        if self.dimension == DIMENSIONLESS:
            percent = {"type": "string", "pattern": editor_pattern(self.dimension), "examples": ["30 %"]}
            return {"anyOf": [{"type": "number"}, percent], "x-unit": ""}
        return {
            "type": "string",
            "pattern": editor_pattern(self.dimension),
            "examples": list(self.dimension.examples),
            "x-unit": self.dimension.unit,
        }

    def _read(self, value: Any, info: ValidationInfo) -> float:
        if isinstance(value, str):
            try:
                return parse(value, self.dimension)
            except UnitError as error:
                raise refuse(str(error)) from None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise refuse(f"expected {self.dimension.expected}, found {show(value)}")
        if info.context and info.context.get("text") and self.dimension != DIMENSIONLESS:
            raise refuse(f"expected {self.dimension.expected}, found {value!r} (no unit)")
        if not math.isfinite(value):
            raise refuse(f"expected a finite {self.dimension.name}, found {value!r}")
        return float(value)

    def _write(self, value: float | str) -> str | float:
        return value if self.dimension == DIMENSIONLESS or isinstance(value, str) else write(value, self.dimension)


class _Bound(NamedTuple):
    keyword: str
    """Of JSON Schema."""
    holds: Callable[[float, float], bool]


_BOUNDS = {
    "above": _Bound("exclusiveMinimum", float.__gt__), "at_least": _Bound("minimum", float.__ge__),
    "below": _Bound("exclusiveMaximum", float.__lt__), "at_most": _Bound("maximum", float.__le__),
}  # fmt: skip
"""Bounds by their field of `Within`."""


@dataclass(frozen=True)
class Within:
    """Annotation of a quantity field with its range, in units, and the reason for it."""

    above: str | None = None
    """Open lower bound, such as `0 m`."""
    at_least: str | None = None
    """Closed lower bound."""
    below: str | None = None
    """Open upper bound."""
    at_most: str | None = None
    """Closed upper bound."""
    reason: str = ""
    """Explanation after the range in messages."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Check the parsed value; the message quotes what was written."""
        written, schema = self._bounds(), handler(source)
        # several dimensions share a unit, such as stiffness and force per length: take the dimension of the field
        dimension = schema["metadata"]["dimension"]
        bounds = [(parse(text, dimension), _BOUNDS[name].holds) for name, text in written.items()]

        def check(value: Any, inner: core_schema.ValidatorFunctionWrapHandler) -> float:
            result: float = inner(value)
            if not all(holds(result, bound) for bound, holds in bounds):
                text = show(value) if isinstance(value, str) else write(result, dimension)
                raise refuse(f"expected {dimension.article}, {self.range_text}, found {text}")
            return result

        return core_schema.no_info_wrap_validator_function(check, schema)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Range as text for editors; in patterns only the sign can be checked."""
        result = {**handler(schema), "x-range": self.range_text}
        lowest = self.above or self.at_least
        if lowest is not None and not lowest.startswith("-") and "pattern" in result:
            result["pattern"] = result["pattern"].replace("[+-]?", "[+]?", 1)
        for branch in result.get("anyOf", ()):
            if branch.get("type") == "number":
                branch.update({_BOUNDS[name].keyword: float(text) for name, text in self._bounds().items()})
        return result

    def _bounds(self) -> dict[str, str]:
        """Texts of the bounds that there are, by field."""
        return {name: text for name in _BOUNDS if (text := getattr(self, name)) is not None}

    @property
    def range_text(self) -> str:
        """Range as text: `above 0 m and at most 5 m`."""
        text = " and ".join(f"{name.replace('_', ' ')} {bound}" for name, bound in self._bounds().items())
        return f"{text} ({self.reason})" if self.reason else text


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


@dataclass(frozen=True)
class Whole:
    """Annotation of a whole number in a range, both bounds included."""

    at_least: int
    at_most: int
    what: str = "a whole number"
    """Expected value in messages."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}

    def _read(self, value: Any) -> int:
        if not isinstance(value, int) or isinstance(value, bool) or not self.at_least <= value <= self.at_most:
            raise refuse(f"expected {self.what} from {self.at_least} to {self.at_most}, found {show(value)}")
        return value
