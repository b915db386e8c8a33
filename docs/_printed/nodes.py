# SPDX-License-Identifier: Apache-2.0
"""Nodes: purpose, topics, services, parameters."""

import json
from collections.abc import Iterable

from _printed.markdown import code, table
from drill_twin.ros import composed_twin, entry_points
from drill_twin.ros.core.parameters import Parameter

_RIGHTS = {"publish": "Publishes", "subscribe": "Subscribes to", "reply": "Services", "request": "Calls"}


def nodes() -> str:
    """A section for each node."""
    return "\n".join([*map(_node, entry_points.node_names()), _together()])


def _node(name: str) -> str:
    node = entry_points.load(name)
    lines = [f"## {name}", "", node.PURPOSE, ""]
    lines += [f"* {_RIGHTS[right]}: {_names(sorted(found))}" for right, found in node.RIGHTS.own(name).items() if found]
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
