# SPDX-License-Identifier: Apache-2.0
"""The last gate: a number that is none reaches no topic and no file."""

from __future__ import annotations

import math

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.errors import MessageError


def finite_only(topic: str, values: Array) -> None:
    """Let an array pass if all of it is finite.

    Raises:
        MessageError: It is not; says which entry.
    """
    if not np.isfinite(values).all():
        place = np.unravel_index(int(np.argmin(np.isfinite(values))), values.shape)
        at, shape = ", ".join(map(str, place)), " x ".join(map(str, values.shape))
        raise MessageError(
            f"{topic}: expected finite numbers, found {values[place]} at place {at} of an array of {shape}; "
            "it was not sent"
        )


def finite_number(topic: str, what: str, value: float) -> float:
    """Let a number pass if it is finite.

    Raises:
        MessageError: It is not.
    """
    if not math.isfinite(value):
        raise MessageError(f"{topic}: expected a finite {what}, found {value}; it was not sent")
    return value


def not_infinite(topic: str, values: Array) -> None:
    """Let an array pass if none of it is infinite; NaN stands for what is not known.

    Raises:
        MessageError: It is not.
    """
    if np.isinf(values).any():
        raise MessageError(f"{topic}: expected finite numbers, or NaN for what is not known, found an infinite one")
