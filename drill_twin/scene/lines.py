# SPDX-License-Identifier: Apache-2.0
"""YAML text to plain data with the line of each key and value, for messages."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from drill_twin.errors import SceneError

Path = tuple[str | int, ...]
"""Place of a value in the data: keys and list indices."""

LARGEST_TEXT = 1_000_000
DEEPEST_NESTING = 40
MOST_VALUES = 100_000

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_SCALARS = {
    f"tag:yaml.org,2002:{kind}": kind for kind in ("str", "int", "float", "bool", "null", "timestamp", "merge", "value")
}
_COLLECTIONS = {"tag:yaml.org,2002:map", "tag:yaml.org,2002:seq"}


@dataclass
class Lines:
    """Data of a YAML text and the line of each part."""

    name: str
    """Name of the text in messages: its file."""
    data: dict[str, Any] = field(default_factory=dict)
    lines: dict[Path, int] = field(default_factory=dict)
    """Line (from 1) of each key or list item."""
    overridden: set[Path] = field(default_factory=set)
    """Places set by an override, not by the text."""
    inherited: dict[Path, str] = field(default_factory=dict)
    """Places taken from the scene named as `base`, with file and line."""

    def order(self, path: Path) -> int:
        """Sort key of a place: its line; overrides come first."""
        place = self._known(path)
        return -1 if place in self.overridden else self.lines.get(place, 0)

    def where(self, path: Path) -> str:
        """`file:line`, or `override`, of a place or of the nearest enclosing place."""
        place = self._known(path)
        if place in self.overridden:
            return f"{self.name}: override"
        if place in self.inherited:
            return self.inherited[place]
        return f"{self.name}:{self.lines[place]}" if place in self.lines else self.name

    def heir(self, path: Path) -> str:
        """`file:line` that takes over a place of the base: the innermost block of this text around it, or `base`."""
        place = self._known(path)
        if place not in self.inherited or place in self.overridden:
            return ""
        around = next(place[:length] for length in range(len(place), -1, -1) if place[:length] in self.lines)
        return f"{self.name}:{self.lines[around or ('base',)]}"

    def inherit(self, base: "Lines") -> None:
        """Fill in what is missing from another text: blocks key by key, anything else (lists too) as a whole.

        A key without a value (`value: ~`) removes that of the base, except for an effect, where it means `on`.
        """
        self._inherit(self.data, base.data, base, ())

    def _inherit(self, own: dict[str, Any], below: dict[str, Any], base: "Lines", path: Path) -> None:
        for key, value in below.items():
            place = (*path, key)
            if key not in own:
                own[key] = value
                inside = [other for other in (*base.lines, *base.inherited) if other[: len(place)] == place]
                self.inherited |= {other: base.where(other) for other in inside}
            elif own[key] is None and not is_effect(place):
                del own[key]
            elif isinstance(own[key], dict) and isinstance(value, dict):
                self._inherit(own[key], value, base, place)

    def _known(self, path: Path) -> Path:
        known = (path[:length] for length in range(len(path), -1, -1))
        places = (self.overridden, self.lines, self.inherited)
        return next((place for place in known if any(place in some for some in places)), ())


def is_effect(place: Path) -> bool:
    """True for the key of an effect, whose empty value means `on`."""
    return len(place) == 2 and place[0] == "effects"


def read_lines(text: str, name: str) -> Lines:
    """Parse a YAML text to plain data with line numbers.

    Raises:
        SceneError: Malformed, too large or too deep, duplicate keys, tags, or not a mapping at the top.
    """
    if len(text) > LARGEST_TEXT:
        raise SceneError(f"{name}: expected a scene of at most {LARGEST_TEXT} characters, found {len(text)}")
    root = _compose(text, name)
    if root is None:
        raise SceneError(f"{name}: expected keys such as `name`, `string`, `hole`, `rig`, found an empty file")
    result = Lines(name)
    data = _Reader(result).read(root, ())
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


def _compose(text: str, name: str) -> yaml.Node | None:
    try:
        depth = 0
        for event in yaml.parse(text, Loader=_Loader):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > DEEPEST_NESTING:
                place = f"{name}:{event.start_mark.line + 1}" if event.start_mark else name
                raise SceneError(f"{place}: expected at most {DEEPEST_NESTING} nested blocks, found more")
        node: yaml.Node | None = yaml.compose(text, Loader=_Loader)
        return node
    except yaml.YAMLError as error:
        raise _malformed(error, name) from None


def _malformed(error: yaml.YAMLError, name: str) -> SceneError:
    mark, begun = getattr(error, "problem_mark", None), getattr(error, "context_mark", None)
    mark = mark or begun
    place = f"{name}:{mark.line + 1}: column {mark.column + 1}" if mark else name
    said = getattr(error, "problem", None) or getattr(error, "reason", None) or " ".join(str(error).split())
    said = str(said).removeprefix("but ").removeprefix("found ")
    since = (
        f" {error.context} from line {begun.line + 1} on" if isinstance(error, yaml.MarkedYAMLError) and begun else ""
    )
    return SceneError(
        f"{place}: expected valid YAML, found: {said}{since}; "
        "an indent, a tab, a quote or a missing `: ` is the usual cause"
    )


class _Reader:
    """Conversion of the nodes of one text to plain data."""

    def __init__(self, result: Lines) -> None:
        self.result = result
        self.values = 0
        self.scalars = _Loader("")

    def read(self, node: yaml.Node, path: Path) -> Any:
        self.result.lines.setdefault(path, node.start_mark.line + 1)
        self.values += 1
        if self.values > MOST_VALUES or len(path) > DEEPEST_NESTING:
            raise self.error(node, "expected a scene, found endless repetition (a YAML alias of itself?)")
        if isinstance(node, yaml.CollectionNode) and node.tag not in _COLLECTIONS:
            raise self.error(node, f"expected plain values, found the YAML tag {node.tag}")
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.read(item, (*path, index)) for index, item in enumerate(node.value)]
        if node.tag not in _SCALARS:
            raise self.error(node, f"expected plain values, found the YAML tag {node.tag}")
        if _SCALARS[node.tag] in {"timestamp", "value", "merge"}:
            return node.value
        try:
            return self.scalars.construct_object(node)
        except ValueError:
            return node.value

    def mapping(self, node: yaml.MappingNode, path: Path) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = self.key(key_node)
            place = (*path, key)
            if key in data:
                raise self.error(
                    key_node, f"expected each key once, found `{key}` again (first in line {self.result.lines[place]})"
                )
            self.result.lines[place] = key_node.start_mark.line + 1
            data[key] = self.read(value_node, place)
        return data

    def key(self, node: yaml.Node) -> str:
        if not isinstance(node, yaml.ScalarNode):
            raise self.error(node, "expected a name as key, found a list or mapping")
        if node.tag == "tag:yaml.org,2002:merge":
            raise self.error(node, "expected keys, found a YAML merge (`<<`); write the values out")
        return str(node.value)

    def error(self, node: yaml.Node, message: str) -> SceneError:
        return SceneError(f"{self.result.name}:{node.start_mark.line + 1}: {message}")
