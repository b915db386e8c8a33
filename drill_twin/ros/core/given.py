# SPDX-License-Identifier: Apache-2.0
"""Parameters that a user gave, and to whom: to one node by its name, or by a wildcard to all nodes.

A wildcard block of a parameter file (`/**:`, `/rig2/**:`, `/*:`) is shared, and a node of ROS 2 leaves alone what it
does not have. rclpy (7.1) does not tell from which block a value came, so that the arguments are read here once more.
"""

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from drill_twin.core.errors import ParameterError
from drill_twin.core.files.yaml_reader import plain_yaml

OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
"""Beginnings of the names of parameters that rclpy itself reads."""


class ArgumentsContext(Context):
    """Context of rclpy that keeps the arguments it is to be initialised with."""

    def __init__(self, arguments: Sequence[str]) -> None:
        super().__init__()
        self.arguments = list(arguments)


def given_parameters(node: Node) -> dict[str, RosParameter]:
    """Parameters that the user gave to a node, by name; a value changed here is declared as changed."""
    given: dict[str, RosParameter] = node._parameter_overrides  # noqa: SLF001 - rclpy has no public access to them
    return given


def refuse_unknown(node: Node, known: Sequence[str], unknown: Iterable[str]) -> list[str]:
    """Refuse a name that was given to a node by the node's own name, or by -p; returns the names given to all nodes.

    Args:
        node: The node.
        known: Names that it has.
        unknown: Names that were given, and that it does not have.

    Raises:
        ParameterError: A name was meant for this node.
    """
    left = list(unknown)
    for name in _addressed(node) & set(left):
        raise ParameterError(f"parameter {name}: this node has none of that name; {_advice(name, known)}")
    return left


def warn_of_misspelled(node: Node, names: Iterable[str], known: Iterable[str]) -> None:
    """Log a warning about each name, given to all nodes, that no node knows.

    Args:
        node: The node that logs.
        names: The names; none is the usual case.
        known: Names that any node has, read only as far as needed.
    """
    left, seen, known = set(names), [], iter(known)
    while left and (name := next(known, None)) is not None:
        left.discard(name)
        seen.append(name)
    for name in sorted(left):
        node.get_logger().warning(
            f"parameter {name}: no node of drill_twin has it; {_advice(name, seen, 'it is unused')}"
        )


def _advice(name: str, known: Sequence[str], otherwise: str = "") -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]}?" if near else otherwise or f"it has {', '.join(known)}"


def _addressed(node: Node) -> set[str]:
    """Names given on the command line, or in a block of a parameter file that names the node."""
    if not isinstance(node.context, ArgumentsContext):
        return set(given_parameters(node))
    found = set()
    for option, value in zip(node.context.arguments, node.context.arguments[1:], strict=False):
        if option in ("-p", "--param"):
            found.add(value.partition(":=")[0].rpartition(":")[2])  # NODE:NAME:=VALUE names the node as well
        elif option == "--params-file":
            for address, block in _blocks(plain_yaml(Path(value).read_text("utf-8"), value)):
                if address.rpartition("/")[2] == node.get_name():
                    found |= set(_names(block))
    return found


def _blocks(data: Any, address: str = "") -> Iterator[tuple[str, Any]]:
    """Blocks of parameters with their addresses, which may be nested: `/rig2: {simulator: {ros__parameters: ...}}`."""
    for key, value in data.items() if isinstance(data, Mapping) else ():
        if key == "ros__parameters":
            yield address, value
        else:
            yield from _blocks(value, f"{address}/{key}")


def _names(block: Any, prefix: str = "") -> Iterator[str]:
    """Names of parameters in a block, names of nested blocks joined by dots."""
    for key, value in block.items() if isinstance(block, Mapping) else ():
        if isinstance(value, Mapping):
            yield from _names(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"
