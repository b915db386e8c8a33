# SPDX-License-Identifier: Apache-2.0
"""YAML text to plain data with the line of each key and value, for messages; plain data to YAML text."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from drill_twin.core.errors import SceneError
from drill_twin.core.files.yaml_reader import Place, YamlError, read_yaml


@dataclass
class Lines:
    """Data of a YAML text and the line of each part."""

    name: str
    """Name of the text in messages: its file."""
    data: dict[str, Any] = field(default_factory=dict)
    lines: dict[Place, int] = field(default_factory=dict)
    """Line (from 1) of each key or list item."""
    overridden: set[Place] = field(default_factory=set)
    """Places set by an override, not by the text."""
    inherited: dict[Place, str] = field(default_factory=dict)
    """Places taken from the scene named as `base`, with file and line."""
    _taken: set[Place] = field(default_factory=set)

    def order(self, path: Place) -> int:
        """Sort key of a place: its line; overrides come first."""
        place = self._known(path)
        return -1 if place in self.overridden else self.lines.get(place, 0)

    def where(self, path: Place) -> str:
        """`file:line`, or `override`, of a place or of the nearest enclosing place."""
        place = self._known(path)
        if place in self.overridden:
            return f"{self.name}: override"
        if place in self.inherited:
            return self.inherited[place]
        return f"{self.name}:{self.lines[place]}" if place in self.lines else self.name

    def heir(self, path: Place) -> str:
        """`file:line` that takes over a place of the base: the innermost block of this text around it, or `base`."""
        place = self._known(path)
        if place not in self.inherited or place in self.overridden:
            return ""
        around = next(place[:length] for length in range(len(place), -1, -1) if place[:length] in self.lines)
        return f"{self.name}:{self.lines[around or ('base',)]}"

    def inherit(self, base: Lines) -> None:
        """Fill in what is missing from another text: blocks key by key, anything else (lists too) as a whole.

        A key without a value (`value: ~`) removes the key of the base; the key of an effect without a value means `on`.
        """
        self._inherit(self.data, base.data, ())
        for place in (*base.lines, *base.inherited):
            if any(place[:length] in self._taken for length in range(1, len(place) + 1)):
                self.inherited[place] = base.where(place)
        self._taken.clear()

    def _inherit(self, own: dict[str, Any], below: dict[str, Any], path: Place) -> None:
        for key, value in below.items():
            place = (*path, key)
            if key not in own:
                own[key] = value
                self._taken.add(place)
            elif own[key] is None and not is_effect(place):
                del own[key]
            elif isinstance(own[key], dict) and isinstance(value, dict):
                self._inherit(own[key], value, place)

    def _known(self, path: Place) -> Place:
        known = (path[:length] for length in range(len(path), -1, -1))
        places = (self.overridden, self.lines, self.inherited)
        return next((place for place in known if any(place in some for some in places)), ())


def is_effect(place: Place) -> bool:
    """True for the key of an effect, whose empty value means `on`."""
    return len(place) == 2 and place[0] == "effects"


def read_lines(text: str, name: str) -> Lines:
    """Parse a YAML text to plain data with line numbers.

    Raises:
        SceneError: Malformed, too large or too deep, duplicate keys, tags, or not a mapping at the top.
    """
    result = Lines(name)
    try:
        data, result.lines = read_yaml(text, name)
    except YamlError as error:
        raise SceneError(str(error)) from None
    if not result.lines:
        raise SceneError(f"{name}: expected keys such as `name`, `string`, `hole`, `rig`, found an empty file")
    if not isinstance(data, dict):
        kind = "a list" if isinstance(data, list) else f'the text "{str(data)[:40]}"'
        raise SceneError(f"{result.where(())}: expected keys such as `name`, `string`, `hole`, `rig`, found {kind}")
    result.data = data
    return result


def copy_plain(data: Any) -> Any:
    """Deep copy of data made in Python, with dicts and lists in place of other mappings and sequences."""
    if isinstance(data, Mapping):
        return {str(key): copy_plain(value) for key, value in data.items()}
    return [copy_plain(item) for item in data] if isinstance(data, list | tuple) else data


_LINE_BREAKS_OF_UNICODE = re.compile("[\x85\u2028\u2029\ufeff]")


def yaml_text(data: dict[str, Any]) -> str:
    """YAML text that reads back to the same data: keys in order, UTF-8, Unicode line breaks escaped."""
    text: str = yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)
    return text


class _Dumper(yaml.SafeDumper):
    """Safe dumper that escapes Unicode line breaks."""


def _represent(dumper: _Dumper, text: str) -> yaml.ScalarNode:
    style = '"' if _LINE_BREAKS_OF_UNICODE.search(text) else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent)
