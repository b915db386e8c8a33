# SPDX-License-Identifier: Apache-2.0
"""Samples over time, collected one by one."""

from __future__ import annotations

from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.errors import MessageError
from drill_twin.io.messages.stamps import NANOSECONDS


class Track:
    """Rows of one shape at rising stamps; a row whose stamp does not rise is left out."""

    def __init__(self) -> None:
        self._stamps: list[int] = []
        self._rows: list[Array] = []

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp: int, row: Any) -> None:
        """Append a row at a stamp [ns].

        Raises:
            MessageError: The row has another shape than those before.
        """
        values = np.asarray(row, np.float64)
        if self._rows and values.shape != self._rows[0].shape:
            raise MessageError(
                f"expected {self._rows[0].shape} values as in the messages before, found {values.shape}; "
                "the bag holds more than one scene"
            )
        if not self._stamps or stamp > self._stamps[-1]:
            self._stamps.append(stamp)
            self._rows.append(values)

    @property
    def time(self) -> Array:
        """Times [s], shape (T,)."""
        return np.array(self._stamps, np.int64) / NANOSECONDS

    @property
    def values(self) -> Array:
        """The rows, shape (T, ...)."""
        return np.array(self._rows, np.float64)
