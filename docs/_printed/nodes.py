# SPDX-License-Identifier: Apache-2.0
"""Nodes: purpose, topics, services, parameters."""

import json
from collections.abc import Iterable
from functools import reduce
from pathlib import Path
from xml.etree import ElementTree as ET

from _printed.markdown import code, table
from drill_twin.ros import composed_twin, entry_points
from drill_twin.ros.core.parameters import Parameter

_ROOT = Path(__file__).parents[2]
_RIGHTS = {"publish": "Publishes", "subscribe": "Subscribes to", "reply": "Services", "request": "Calls"}


def nodes() -> str:
    """A section for each node."""
    rights = {name: _rights(name) for name in entry_points.node_names()}
    of_every_node = {right: reduce(set.__and__, (found[right] for found in rights.values())) for right in _RIGHTS}
    own = {
        name: {right: sorted(found[right] - of_every_node[right]) for right in _RIGHTS}
        for name, found in rights.items()
    }
    return "\n".join([*(_node(name, found) for name, found in own.items()), _together()])


def _rights(node: str) -> dict[str, set[str]]:
    """Topics and services of a security policy by right."""
    folders = (_ROOT / "config", *_ROOT.glob("companions/*/config"))
    (file,) = (path for folder in folders if (path := folder / f"security/{node}.policy.xml").exists())
    found: dict[str, set[str]] = {right: set() for right in _RIGHTS}
    for group in ET.parse(file).iterfind("enclaves/enclave/profiles/profile/*"):  # noqa: S314 - our own file
        names = (item.text or "" for item in group)
        found[next(iter(group.attrib))] |= {f"/{name}" if group.tag == "topics" else name for name in names}
    return found


def _node(name: str, rights: dict[str, list[str]]) -> str:
    node = entry_points.load(name)
    lines = [f"## {name}", "", node.PURPOSE, ""]
    lines += [f"* {title}: {_names(rights[right])}" for right, title in _RIGHTS.items() if rights[right]]
    return "\n".join([*lines, "", _parameters(node.PARAMETERS)])


def _together() -> str:
    return f"## {composed_twin.NAME}\n\n{composed_twin.PURPOSE}\n\n{_parameters(composed_twin.PARAMETERS)}"


def _names(names: Iterable[str]) -> str:
    return ", ".join(code(name) for name in names)


def _parameters(parameters: Iterable[Parameter]) -> str:
    rows = (
        (code(item.name), item.description, item.expected(), code(json.dumps(item.default)),
         "yes" if item.live else "")
        for item in parameters
    )  # fmt: skip
    return table(("parameter", "meaning", "expected", "default", "live"), rows)
