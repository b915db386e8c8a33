# SPDX-License-Identifier: Apache-2.0
"""Help text and parameter file of a node, from its table of parameters."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from drill_twin.ros.core.parameters import Parameter, Value


def file_text(name: str, purpose: str, table: Sequence[Parameter]) -> str:
    """Parameter file of a node, `config/nodes/NAME.yaml`: every parameter with its default and description."""
    reading = "read when the node starts; those marked live can be set while it runs"
    if not any(parameter.live for parameter in table):
        reading = "each is read once, when the node starts"
    lines = [
        f"# {purpose}",
        f"# ros2 run drill_twin {name} --ros-args --params-file {name}.yaml",
        f"# Every parameter with its default; {reading}.",
        "",
        "/**:",
        "  ros__parameters:",
    ]
    for parameter in table:
        live = " Live." if parameter.live else ""
        comment = f"{_sentence(parameter.description)}. {_sentence(parameter.expected())}.{live}"
        lines += textwrap.wrap(comment, 113, initial_indent="    # ", subsequent_indent="    # ")
        lines += [f"    {parameter.name}: {_yaml(parameter.default)}", ""]
    return "\n".join(lines[:-1]) + "\n"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _yaml(value: Value) -> str:
    return f'"{value}"' if isinstance(value, str) else f"{value}".lower()


def help_text(name: str, purpose: str, table: Sequence[Parameter]) -> str:
    """Text that `NODE --help` prints."""
    lines = [
        f"usage: {name} [--ros-args [-p NAME:=VALUE ...] [--params-file FILE] [-r FROM:=TO ...]]",
        "",
        purpose,
        "",
        "parameters:",
    ]
    for parameter in table:
        expected = f"{parameter.expected()}; {'live' if parameter.live else 'read at the start'}"
        lines += [
            f"  {parameter.name} = {_yaml(parameter.default)}",
            f"      {parameter.description}",
            f"      {expected}",
        ]
    return "\n".join(lines)
