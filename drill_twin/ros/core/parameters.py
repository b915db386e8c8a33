# SPDX-License-Identifier: Apache-2.0
"""Typed parameters: one table per node, the source of its descriptors, checks and defaults.

A node refuses to start on a parameter of the wrong type, out of range or misspelled, with one line.
"""

from __future__ import annotations

import difflib
import json
import math
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from drill_twin.core.errors import DrillTwinError, shortened

Value = bool | int | float | str

_OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
_TYPE_NAMES = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}


class ParameterError(DrillTwinError):
    """A node parameter with which a node cannot start."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node; read once at its start, unless it is live."""

    name: str
    default: Value
    description: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    live: bool = False
    """True if it can be changed while the node runs."""
    such_as: str = ""
    """Example of a valid text."""

    def expected(self) -> str:
        """Expected type and range of a value, in words."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        text = _TYPE_NAMES[type(self.default)]
        if self.such_as:
            text += f' such as "{self.such_as}"'
        if self.low is not None and self.high is not None:
            text += f" from {self.low:g} to {self.high:g}"
        return f"{text} [{self.unit}]" if self.unit else text

    def checked(self, value: object) -> Value:
        """Value converted to the type of the default.

        Raises:
            ParameterError: The value has another type or is out of range.
        """
        wanted = type(self.default)
        if wanted is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is not wanted or not self._admits(value):
            raise ParameterError(f"parameter {self.name}: expected {self.expected()}, found {shortened(repr(value))}")
        return value

    def _admits(self, value: Value) -> bool:
        if self.choices and value not in self.choices:
            return False
        if isinstance(value, str):
            return True
        return math.isfinite(value) and not (
            (self.low is not None and value < self.low) or (self.high is not None and value > self.high)
        )

    def descriptor(self) -> ParameterDescriptor:
        """Descriptor that `ros2 param describe` shows."""
        description = f"{self.description} [{self.unit}]" if self.unit else self.description
        descriptor = ParameterDescriptor(description=description, read_only=not self.live)
        if self.choices:
            descriptor.additional_constraints = self.expected()
        if self.low is not None and self.high is not None:
            if isinstance(self.default, float):
                bounds = FloatingPointRange(from_value=float(self.low), to_value=float(self.high))
                descriptor.floating_point_range = [bounds]
            else:
                descriptor.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high))]
        return descriptor


def given_parameters(node: Node) -> dict[str, RosParameter]:
    """Parameters that the user gave to a node, by name; a value changed here is declared as changed."""
    given: dict[str, RosParameter] = node._parameter_overrides  # noqa: SLF001 - rclpy has no public access to them
    return given


def declare(node: Node, table: Sequence[Parameter], other_names: Iterable[str] = ()) -> SimpleNamespace:
    """Declare a table on a node; returns its values by name.

    Args:
        node: A node without declared parameters of its own.
        table: The parameters.
        other_names: Names that belong to other nodes of the same process.

    Raises:
        ParameterError: The user gave a parameter that this node cannot start with.
    """
    given = given_parameters(node)
    names = [parameter.name for parameter in table]
    _refuse_unknown(given, names, {*names, *other_names})
    result = {}
    for parameter in table:
        if parameter.name in given:
            value = parameter.checked(given[parameter.name].value)
            given[parameter.name] = RosParameter(parameter.name, value=value)
        else:
            value = parameter.default
        node.declare_parameter(parameter.name, value, parameter.descriptor())
        result[parameter.name] = value
    return SimpleNamespace(**result)


def follow_changes(
    node: Node,
    table: Sequence[Parameter],
    settings: SimpleNamespace,
    *,
    check: Callable[[SimpleNamespace], None],
    changed: Callable[[], None],
) -> None:
    """Write live parameters that are set while the node runs into its settings.

    Args:
        node: A node that has declared the table.
        table: The parameters.
        settings: Values of the parameters by name.
        check: Called with the settings as they would be; refuses the change by raising a DrillTwinError.
        changed: Called after the settings have changed.
    """
    live = {parameter.name: parameter for parameter in table if parameter.live}

    def checked(changes: Sequence[RosParameter]) -> SetParametersResult:
        try:
            if not all(change.name for change in changes):  # rclpy takes an empty name for an existing parameter
                raise ParameterError("expected the name of a parameter, found an empty text")
            wanted = {change.name: live[change.name].checked(change.value) for change in changes if change.name in live}
            if wanted:
                check(SimpleNamespace(**{**vars(settings), **wanted}))
        except DrillTwinError as error:
            return SetParametersResult(successful=False, reason=shortened(str(error), 500))
        return SetParametersResult(successful=True)

    def take_over(changes: Sequence[RosParameter]) -> None:
        known = {change.name: live[change.name].checked(change.value) for change in changes if change.name in live}
        vars(settings).update(known)
        if known:
            changed()

    node.add_on_set_parameters_callback(checked)
    node.add_post_set_parameters_callback(take_over)


def _refuse_unknown(given: Mapping[str, RosParameter], names: Sequence[str], known: set[str]) -> None:
    for name in given:
        if name in known or name.startswith(_OF_ROS):
            continue
        near = difflib.get_close_matches(name, names, n=1)
        hint = f"did you mean {near[0]}?" if near else f"it has {', '.join(names)}"
        raise ParameterError(f"parameter {name}: this node has none of that name; {hint}")


# --- texts --------------------------------------------------------------------------------------------------------


def file_text(name: str, purpose: str, table: Sequence[Parameter]) -> str:
    """Parameter file of a node, `config/nodes/NAME.yaml`: every parameter with its default and description."""
    reading = "read when the node starts; parameters marked live can be set while it runs"
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
        lines += [f"    {parameter.name}: {json.dumps(parameter.default)}", ""]
    return "\n".join(lines[:-1]) + "\n"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


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
            f"  {parameter.name} = {json.dumps(parameter.default)}",
            f"      {parameter.description}",
            f"      {expected}",
        ]
    return "\n".join(lines)
