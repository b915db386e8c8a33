# SPDX-License-Identifier: Apache-2.0
"""Checks that values to be published are finite."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError, NotFiniteError


def check_finite(topic: str, values: Array) -> None:
    """Check that all values are finite.

    Raises:
        NotFiniteError: A value is not finite; names the first one.
    """
    if not np.isfinite(values).all():
        place = np.unravel_index(int(np.argmin(np.isfinite(values))), values.shape)
        at, shape = ", ".join(map(str, place)), " x ".join(map(str, values.shape))
        raise NotFiniteError(
            f"{topic}: expected finite numbers, found {values[place]} at place {at} of an array of {shape}; "
            "it was not sent"
        )


def check_rows(topic: str, values: Array) -> None:
    """Check that all values of several messages are finite, one message a row.

    Raises:
        NotFiniteError: A value is not finite; names the first one, in the first such message.
    """
    if not np.isfinite(values).all():
        for row in values:
            check_finite(topic, row)


def finite_number(topic: str, what: str, value: float) -> float:
    """Return a number if it is finite.

    Raises:
        MessageError: It is not finite.
    """
    if not math.isfinite(value):
        raise MessageError(f"{topic}: expected a finite {what}, found {value}; it was not sent")
    return value


def check_not_infinite(topic: str, values: Array) -> None:
    """Check that no value is infinite; NaN stands for an unknown value.

    Raises:
        NotFiniteError: A value is infinite.
    """
    if np.isinf(values).any():
        raise NotFiniteError(f"{topic}: expected finite numbers, or NaN for what is not known, found an infinite one")
