# SPDX-License-Identifier: Apache-2.0
"""Array over time that grows message by message, with named columns; T samples, by header stamp."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array
from drill_twin.errors import MessageError
from drill_twin.io.messages.stamps import NANOSECONDS


class Series:
    """Rows of one shape at rising stamps; a row whose stamp does not rise is left out."""

    def __init__(self) -> None:
        self._stamps: list[int] = []
        self._rows: list[Array] = []
        self._stacked = np.zeros(0)

    def __len__(self) -> int:
        return len(self._stamps)

    def append(self, stamp: int, row: Any) -> None:
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
    def stamp(self) -> NDArray[np.int64]:
        """Header stamps [ns], shape (T,)."""
        return np.array(self._stamps, np.int64)

    @property
    def time(self) -> Array:
        """Header stamps as time [s], shape (T,)."""
        return self.stamp / NANOSECONDS

    @property
    def values(self) -> Array:
        """The rows, shape (T, ...); read-only."""
        if len(self._stacked) != len(self._rows):
            self._stacked = np.array(self._rows, np.float64)
            self._stacked.flags.writeable = False
        return self._stacked


class Column:
    """Property of a series: one part of each row, shape (T, ...); of shape (0,) where there is no row."""

    def __init__(self, *place: int | slice) -> None:
        self._place = (slice(None), *place)

    def __get__(self, series: Series, owner: type[Series]) -> Array:
        return series.values[self._place] if len(series) else series.values
