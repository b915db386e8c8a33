# SPDX-License-Identifier: Apache-2.0
"""Quantities as arguments: numbers in a documented unit, or text with a unit of its own."""

import math

from drill_twin.core.errors import ArgumentError
from drill_twin.core.units import Dimension, UnitError, parse

Quantity = float | str
"""Number in the documented unit, or text with its unit, such as `"40 N"`."""


def in_si(name: str, value: Quantity, dimension: Dimension, unit: float = 1.0) -> float:
    """SI value of an argument.

    Args:
        name: Name of the argument, for the message.
        value: The argument.
        dimension: Its dimension.
        unit: SI value of the unit that a number is in.

    Raises:
        ArgumentError: Not a finite number, or text that is no quantity of the dimension.
    """
    if isinstance(value, str):
        try:
            return parse(value, dimension)
        except UnitError as error:
            raise ArgumentError(f"{name}: {error}") from None
    try:
        number = float(value) * unit
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise ArgumentError(f"{name}: expected {dimension.expected} or a finite number, found {value!r}")
    return number
