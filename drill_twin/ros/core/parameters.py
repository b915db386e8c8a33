# SPDX-License-Identifier: Apache-2.0
"""Typed parameters: one table per node, the source of its descriptors, checks and defaults.

A node refuses to start on a parameter of the wrong type, out of range or misspelled, with one line. A quantity is a
number in its SI unit, or a text with any unit of scene files, `"120 rpm"`. A speed of rotation always has its unit: a
bare 12 might be meant in rad/s, rev/s or rev/min.
"""

import json
import math
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from drill_twin.core.errors import DrillTwinError, ParameterError, shortened
from drill_twin.core.numerals import number
from drill_twin.core.units import UnitError, parse, write
from drill_twin.core.units import dimension as dim
from drill_twin.ros.core.given import OF_ROS, given_parameters, refuse_unknown

Value = bool | int | float | str | tuple[str, ...]

_TYPE_NAMES = {bool: "true or false", int: "a whole number", float: "a number", str: "a text", tuple: "a list of texts"}
_UNITS = (
    'A number with a unit in brackets may also be a text such as "500 ms", of any unit of scene files. A speed of '
    "rotation always has its unit."
)
_DIMENSIONS = {known.unit: known for known in (dim.FORCE, dim.TIME, dim.FREQUENCY, dim.ANGULAR_SPEED)}


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node; read once at its start, unless it is live."""

    name: str
    default: Value
    description: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    live: bool = False
    """True if it can be changed while the node runs."""
    such_as: str = ""
    """Example of a valid text or list."""
    between: str = " "
    """Text between the items of a list that is written as one text, as launch arguments are."""

    def expected(self) -> str:
        """Expected type and range of a value, in words."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        text = _TYPE_NAMES[type(self.default)]
        if self.such_as:
            text += f" such as {self.such_as if isinstance(self.default, tuple) else json.dumps(self.such_as)}"
        if self._dimension is dim.ANGULAR_SPEED:
            text = 'a text with a unit such as "120 rpm"'
        elif self._dimension and isinstance(self.default, str):
            text = f"a number [{self.unit}] or {text}"
        if math.isfinite(self.low):
            text += f" from {self.low:g} to {self.high:g}"
        return f"{text} [{self.unit}]" if self.unit and not isinstance(self.default, str) else text

    @property
    def _dimension(self) -> dim.Dimension | None:
        return _DIMENSIONS.get(self.unit)

    def checked(self, value: object) -> Value:
        """Value as the node has it: of the type of the default, a quantity in SI.

        Raises:
            ParameterError: The value has another type or unit, or is out of range.
        """
        wanted, found = type(self.default), value
        if isinstance(self.default, tuple):
            value = self._items(value)
        elif self._dimension is not None:
            value = self._quantity(value, self._dimension)
        if wanted is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is not wanted or not self._admits(value):
            raise ParameterError(f"parameter {self.name}: expected {self.expected()}, found {shortened(repr(found))}")
        return value

    def _items(self, value: object) -> object:
        """Items of a list, also of a list written as one text; ROS has no value for an empty list in a file."""
        if isinstance(value, str):
            value = value.split(self.between)
        items: Sequence[object] = value if isinstance(value, Sequence) else () if value is None else (value,)
        texts = [item.strip() for item in items if isinstance(item, str)]
        return tuple(filter(None, texts)) if len(texts) == len(items) else value

    def _quantity(self, value: object, dimension: dim.Dimension) -> object:
        """Value in SI, or with its unit where the default is a text, which the scene reads."""
        bare = number(value.strip()) if isinstance(value, str) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            bare = float(value)
        if bare and dimension is dim.ANGULAR_SPEED:
            raise ParameterError(f"parameter {self.name}: expected {self.expected()}, found {value!r} without a unit")
        if isinstance(self.default, str):
            return value if bare is None else write(bare, dimension)
        try:
            return parse(value, dimension) if isinstance(value, str) else value
        except UnitError as error:
            raise ParameterError(f"parameter {self.name}: {error}") from error

    def _admits(self, value: Value) -> bool:
        if isinstance(value, (str, tuple)):
            return not self.choices or value in self.choices
        return math.isfinite(value) and self.low <= value <= self.high

    def declared(self, value: Value) -> Any:
        """Value of the default's type as ROS is told it; a list without items as a list of an empty text."""
        return list(value) or [""] if isinstance(value, tuple) else value

    def descriptor(self) -> ParameterDescriptor:
        """Descriptor that `ros2 param describe` shows; a quantity is a number or a text."""
        description = f"{self.description} [{self.unit}]" if self.unit else self.description
        descriptor = ParameterDescriptor(description=description, read_only=not self.live)
        descriptor.dynamic_typing = self._dimension is not None
        if self.choices or descriptor.dynamic_typing:
            descriptor.additional_constraints = self.expected()
        if math.isfinite(self.low):
            if isinstance(self.default, float):
                descriptor.floating_point_range = [FloatingPointRange(from_value=self.low, to_value=self.high)]
            else:
                descriptor.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high))]
        return descriptor


def declare(
    node: Node, table: Sequence[Parameter], other_names: Iterable[str] = ()
) -> tuple[SimpleNamespace, list[str]]:
    """Declare a table on a node; returns its values by name, and names given to all nodes that this node lacks.

    Args:
        node: A node without declared parameters of its own.
        table: The parameters.
        other_names: Names that belong to other nodes of the same process.

    Raises:
        ParameterError: The user gave a parameter that this node cannot start with.
    """
    given = given_parameters(node)
    names = [parameter.name for parameter in table]
    known = {*names, *other_names}
    unknown = refuse_unknown(node, names, [name for name in given if name not in known and not name.startswith(OF_ROS)])
    result = {}
    for parameter in table:
        value, descriptor = parameter.default, parameter.descriptor()
        if parameter.name in given:
            found = given[parameter.name].value
            value = parameter.checked(found)
            as_told = found if descriptor.dynamic_typing else parameter.declared(value)  # with its unit
            given[parameter.name] = RosParameter(parameter.name, value=as_told)
        node.declare_parameter(parameter.name, parameter.declared(value), descriptor)
        result[parameter.name] = value
    return SimpleNamespace(**result), unknown


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

    def wanted(changes: Sequence[RosParameter]) -> dict[str, Value]:
        return {change.name: live[change.name].checked(change.value) for change in changes if change.name in live}

    def checked(changes: Sequence[RosParameter]) -> SetParametersResult:
        try:
            if not all(change.name for change in changes):  # rclpy takes an empty name for an existing parameter
                raise ParameterError("expected the name of a parameter, found an empty text")
            if known := wanted(changes):
                check(SimpleNamespace(**{**vars(settings), **known}))
        except DrillTwinError as error:
            return SetParametersResult(successful=False, reason=shortened(str(error), 500))
        return SetParametersResult(successful=True)

    def take_over(changes: Sequence[RosParameter]) -> None:
        if known := wanted(changes):
            vars(settings).update(known)
            changed()

    node.add_on_set_parameters_callback(checked)
    node.add_post_set_parameters_callback(take_over)


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
        *textwrap.wrap(_UNITS, 113, initial_indent="# ", subsequent_indent="# "),
        "",
        "/**:",
        "  ros__parameters:",
    ]
    for parameter in table:
        live = " Live." if parameter.live else ""
        told = [text[:1].upper() + text[1:] for text in (parameter.description, parameter.expected())]
        lines += textwrap.wrap(f"{'. '.join(told)}.{live}", 113, initial_indent="    # ", subsequent_indent="    # ")
        lines += [f"    {parameter.name}: {json.dumps(parameter.default)}", ""]
    return "\n".join(lines[:-1]) + "\n"
