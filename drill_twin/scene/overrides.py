# SPDX-License-Identifier: Apache-2.0
"""Overrides of scene values, such as `rig.rotation.value` by `"50 rpm"`, from the command line and launch files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from drill_twin.core.errors import SceneError
from drill_twin.core.files.yaml_reader import YamlError, plain_yaml
from drill_twin.core.numerals import number, whole_number
from drill_twin.scene.lines import Lines, is_effect

if TYPE_CHECKING:
    from drill_twin.scene import Scene

SHORTHANDS = {
    "wob": ("rig.weight_on_bit.value", "N"),
    "rpm": ("rig.rotation.value", "rpm"),
    "duration": ("rig.duration", "s"),
    "accuracy": ("numerics.accuracy", ""),
}
"""Short name -> its key and the unit of a bare number."""

_LONGEST_KEY = 300  # characters
_INDEX = re.compile(r"\[(\w+)\]")


def full_key(key: str, scene: Scene) -> str:
    """Full key of a number of a scene; an effect needs no `effects.` before it, `wob` and `rpm` are short names."""
    key = SHORTHANDS.get(key, (key, ""))[0]
    return f"effects.{key}" if key.partition(".")[0] in scene.effect_names else key


def apply_overrides(lines: Lines, overrides: Mapping[str, float | str]) -> None:
    """Set each override in the data; a list item is addressed by its index or `name`: `string.marks.mark_1.on`.

    An effect that the data list needs no `effects.` before it. An empty value (`~`) removes a key, except for an
    effect, where it means `on`; `accuracy` replaces the elements, step and tolerance of the data.

    Raises:
        SceneError: An unknown key, a value that is not YAML, or a weight on bit without a unit in field units.
    """
    if "accuracy" in overrides:
        chosen = dict.fromkeys(("numerics.elements", "numerics.step", "numerics.tolerance"), "auto")
        overrides = {**chosen, **overrides}
    for key, given in overrides.items():
        if key == "wob" and str(given).lstrip().startswith("-"):
            raise SceneError(
                f"{lines.name}: override: wob: expected a weight on bit from 0, found {str(given)[:60]}; a bit that is "
                "pulled is given by rig.weight_on_bit.value"
            )
        if (
            key == "wob"
            and _is_bare(given)
            and float(given)
            and overrides.get("units", lines.data.get("units")) == "field"
        ):
            raise SceneError(
                f"{lines.name}: override: wob: expected a weight on bit with its unit in a scene of field units, as "
                f'"25 klbf", found "{given}", which would be in N'
            )
        if len(key) > _LONGEST_KEY:
            raise SceneError(
                f"{lines.name}: override: expected a key of at most {_LONGEST_KEY} characters, found {len(key)}"
            )
        place, value = _expand(lines, key, given)
        _set(lines, key, place, _value(lines, key, value) if isinstance(value, str) else value)


def _expand(lines: Lines, key: str, given: float | str) -> tuple[str, float | str]:
    if key not in SHORTHANDS:
        listed = lines.data.get("effects")
        short = isinstance(listed, dict) and key.partition(".")[0] in listed
        return f"effects.{key}" if short else key, given
    place, unit = SHORTHANDS[key]
    text = str(given)
    return place, f"{text} {unit}".rstrip() if _is_bare(text) else text


def _is_bare(given: float | str) -> bool:
    """True for a number in text, without a unit."""
    return isinstance(given, str) and number(given.strip()) is not None


def _value(lines: Lines, key: str, text: str) -> Any:
    try:
        return plain_yaml(text)
    except YamlError:
        raise SceneError(f"{lines.name}: override: {key}: expected a value, found {text[:100]!r}") from None


def _set(lines: Lines, key: str, place: str, value: Any) -> None:
    parts = [part for part in _INDEX.sub(r".\1", place).split(".") if part]
    if not parts:
        raise SceneError(f'{lines.name}: override: expected a key such as "rig.duration", found {key!r}')
    inside: Any = lines.data
    path: tuple[str | int, ...] = ()
    for depth, part in enumerate(parts):
        step = _item(inside, part)
        last = depth == len(parts) - 1
        if step is None or (isinstance(step, int) and isinstance(inside, dict)):
            raise SceneError(f"{lines.name}: override: {key}: expected a key of the scene, found no `{part}`")
        path = (*path, step)
        if last:
            if value is None and isinstance(inside, dict) and step in inside and not is_effect(path):
                del inside[step]
            else:
                inside[step] = value
            lines.overridden.add(path)
        else:
            if isinstance(inside, dict) and inside.get(step) in (None, True):
                inside[step] = {}
                lines.overridden.add(path)
            inside = inside[step]


def _item(inside: Any, part: str) -> str | int | None:
    """Key or index of a part of an override's key; None if there is none."""
    if isinstance(inside, dict):
        return part
    if isinstance(inside, list):
        if (index := whole_number(part)) is not None and index < len(inside):
            return index
        names = [item.get("name") if isinstance(item, dict) else None for item in inside]
        return names.index(part) if part in names else None
    return None
