# SPDX-License-Identifier: Apache-2.0
"""Plain data from a YAML text of unknown origin, in bounded time and memory.

Length of the text, depth and number of values are checked on the events of the parser, before anything is built of
them, and again while aliases are expanded. Tags and merge keys are refused; dates, and integers of hundreds of digits,
stay texts.
"""

import re
from typing import Any

import yaml

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.numerals import NUMBER

LARGEST_TEXT = 1_000_000
"""Characters of a text."""
DEEPEST_NESTING = 40
MOST_VALUES = 50_000
"""Values of a text, with each alias expanded."""
MOST_KEYS = 5_000
"""Keys of one block."""
LONGEST_KEY = 200
_LONGEST_NUMBER, _LARGEST_INTEGER = 300, 10**300  # characters; the largest float is below 10**309
_MALFORMED = "an indent, a tab, a quote or a missing `: ` is the usual cause"

Place = tuple[str | int, ...]
"""Place of a value in the data: keys and list indices."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_NUMBER = re.compile(rf"(?![+-]?0\d){NUMBER}|[+-]?\.(inf|nan)", re.ASCII | re.IGNORECASE)
_SCALARS = {
    f"tag:yaml.org,2002:{kind}": kind for kind in ("str", "int", "float", "bool", "null", "timestamp", "merge", "value")
}
_COLLECTIONS = {"tag:yaml.org,2002:map", "tag:yaml.org,2002:seq"}
_TEXTS = {"str", "timestamp", "value", "merge"}


class YamlError(DrillTwinError):
    """A text that is not YAML, not plain data, or beyond the bounds; the message has name and line."""


def read_yaml(text: str, name: str) -> tuple[Any, dict[Place, int]]:
    """Plain data of a YAML text, and the line (from 1) of each key and list item; None for an empty text.

    Args:
        text: The text.
        name: Its name in messages.

    Raises:
        YamlError: Malformed, too large or too deep, duplicate keys, tags or merge keys.
    """
    if len(text) > LARGEST_TEXT:
        raise YamlError(f"{name}: expected a text of at most {LARGEST_TEXT} characters, found {len(text)}")
    try:
        _check_events(text, name)
        root = yaml.compose(text, Loader=_Loader)
    except yaml.YAMLError as error:
        raise _malformed(error, name) from None
    if root is None:
        return None, {}
    reader = _Reader(name)
    return reader.read(root, ()), reader.lines


def plain_yaml(text: str, name: str = "YAML") -> Any:
    """Plain data of a YAML text, as `read_yaml`."""
    return read_yaml(text, name)[0]


def _check_events(text: str, name: str) -> None:
    """Count what the composer would build, before it does; an alias counts as one value.

    Raises:
        YamlError: A bound is exceeded.
    """
    depth = values = 0
    for event in yaml.parse(text, Loader=_Loader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        values += isinstance(event, yaml.NodeEvent)
        _check_bounds(event, name, depth, values)


def _check_bounds(found: yaml.Event | yaml.Node, name: str, depth: int, values: int) -> None:
    place = f"{name}:{found.start_mark.line + 1}" if found.start_mark else name
    if depth > DEEPEST_NESTING:
        raise YamlError(
            f"{place}: expected at most {DEEPEST_NESTING} nested blocks, found more or endless repetition (an alias of "
            "itself)"
        )
    if values > MOST_VALUES:
        raise YamlError(f"{place}: expected at most {MOST_VALUES} values, found more or endless repetition")


def _malformed(error: yaml.YAMLError, name: str) -> YamlError:
    mark, begun = getattr(error, "problem_mark", None), getattr(error, "context_mark", None)
    mark = mark or begun
    place = f"{name}:{mark.line + 1}: column {mark.column + 1}" if mark else name
    said = getattr(error, "problem", None) or getattr(error, "reason", None) or " ".join(str(error).split())
    said = str(said).removeprefix("but ").removeprefix("found ")
    if said == "exceeded maximum nesting depth":  # libyaml of PyYAML 6.0.4 reads ahead of the check of events
        return YamlError(f"{place}: expected at most {DEEPEST_NESTING} nested blocks, found more")
    since = (
        f" {error.context} from line {begun.line + 1} on" if isinstance(error, yaml.MarkedYAMLError) and begun else ""
    )
    return YamlError(f"{place}: expected valid YAML, found: {said}{since}; {_MALFORMED}")


class _Reader:
    """Conversion of the nodes of one text to plain data."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.lines: dict[Place, int] = {}
        self.scalars, self.values = _Loader(""), 0

    def read(self, node: yaml.Node, path: Place) -> Any:
        """Plain data of a node, each alias in it expanded."""
        self.values += 1
        _check_bounds(node, self.name, len(path), self.values)
        self.lines.setdefault(path, node.start_mark.line + 1)
        if isinstance(node, yaml.CollectionNode) and node.tag not in _COLLECTIONS:
            raise self.error(node, f"expected plain values, found the YAML tag {node.tag[:100]}")
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.read(item, (*path, index)) for index, item in enumerate(node.value)]
        if node.tag not in _SCALARS:
            raise self.error(node, f"expected plain values, found the YAML tag {node.tag[:100]}")
        if _SCALARS[node.tag] in _TEXTS:
            return node.value
        return self.scalar(node)

    def scalar(self, node: yaml.Node) -> Any:
        """Number, truth value or nothing; else the text, also of what YAML 1.1 reads as 010 in eights, 1_0 or 1:30."""
        unread = _SCALARS[node.tag] in {"int", "float"} and not _NUMBER.fullmatch(node.value)
        if unread or len(node.value) > _LONGEST_NUMBER:
            return node.value
        try:
            value = self.scalars.construct_object(node)
            return node.value if isinstance(value, int) and abs(value) > _LARGEST_INTEGER else value
        except (ValueError, KeyError, IndexError):
            return node.value

    def mapping(self, node: yaml.MappingNode, path: Place) -> dict[str, Any]:
        if len(node.value) > MOST_KEYS:
            raise self.error(node, f"expected at most {MOST_KEYS} keys in a block, found {len(node.value)}")
        data: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = self.key(key_node)
            place = (*path, key)
            if key in data:
                raise self.error(
                    key_node, f"expected each key once, found `{key}` again (first in line {self.lines[place]})"
                )
            self.lines[place] = key_node.start_mark.line + 1
            data[key] = self.read(value_node, place)
        return data

    def key(self, node: yaml.Node) -> str:
        if not isinstance(node, yaml.ScalarNode):
            raise self.error(node, "expected a name as key, found a list or mapping")
        if node.tag == "tag:yaml.org,2002:merge":
            raise self.error(node, "expected keys, found a YAML merge (`<<`); write the values out")
        if len(node.value) > LONGEST_KEY:
            raise self.error(node, f"expected a key of at most {LONGEST_KEY} characters, found {len(node.value)}")
        return str(node.value)

    def error(self, node: yaml.Node, message: str) -> YamlError:
        return YamlError(f"{self.name}:{node.start_mark.line + 1}: {message}")
