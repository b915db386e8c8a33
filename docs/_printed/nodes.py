# SPDX-License-Identifier: Apache-2.0
"""Nodes: purpose, topics, services, parameters."""

import json
from collections.abc import Iterable

from _printed.markdown import code, table
from drill_twin.ros import entry_points
from drill_twin.ros.composed_twin import ComposedTwin
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.permissions import all_rights


def nodes() -> str:
    """A section for each node."""
    return "\n".join([*(_node(name) for name in entry_points.node_names()), _together()])


def _node(name: str) -> str:
    node, rights = entry_points.load(name), all_rights()[name]
    lists = (
        ("Publishes", rights.publish),
        ("Subscribes to", rights.subscribe),
        ("Services", rights.reply),
        ("Calls", rights.request),
    )
    lines = [f"## {name}", "", node.PURPOSE, ""]
    lines += [f"* {title}: {_names(names)}" for title, names in lists if names]
    return "\n".join([*lines, "", _parameters(node.PARAMETERS)])


def _together() -> str:
    return f"## {ComposedTwin.NAME}\n\n{ComposedTwin.PURPOSE}\n\n{_parameters(ComposedTwin.PARAMETERS)}"


def _names(names: Iterable[str]) -> str:
    return ", ".join(code(name) for name in names)


def _parameters(parameters: Iterable[Parameter]) -> str:
    rows = (
        (code(item.name), item.description, item.expected(), code(json.dumps(item.default)),
         "yes" if item.live else "")
        for item in parameters
    )  # fmt: skip
    return table(("parameter", "meaning", "expected", "default", "live"), rows)
