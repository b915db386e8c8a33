# SPDX-License-Identifier: Apache-2.0
"""Array over time that grows message by message, with named columns; T samples, by header stamp."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.io.messages.decode import JointStates
from drill_twin.io.messages.stamps import NANOSECONDS

_LARGEST = 1e15
_Layout = tuple[tuple[str, ...], tuple[int, ...]]  # names, shape of a row


@dataclass(eq=False)
class _Rows:
    """Rows of one layout so far."""

    first: int = 0
    """Stamp of the first row [ns]."""
    count: int = 0
    """Number of rows, with the rows that are not kept."""
    stamps: list[int] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)


class Rows(NamedTuple):
    """Rows of one layout."""

    stamps: Sequence[int]
    """Stamps [ns]."""
    values: Array
    """Shape (n, ...)."""
    names: tuple[str, ...] = ()
    """Names of the parts of a row."""
    kept: Sequence[bool] | None = None
    """Rows that are kept; None: all."""
    states: JointStates | None = None
    """The messages of the rows, where they are JointStates."""


class Series:
    """Rows at rising stamps; a row whose stamp does not rise is left out.

    Rows of several layouts (names or shape) may come: the series has the rows of the layout with most rows.
    """

    def __init__(self) -> None:
        self._layouts: dict[_Layout, _Rows] = {}
        self._stacked: tuple[_Rows, Array] = (_Rows(), np.zeros(0))

    def __len__(self) -> int:
        return len(self._main.stamps)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parts of a row, such as marks; empty where the parts are fixed."""
        return self._main_layout[0]

    def append(self, stamp: int, row: Any, names: tuple[str, ...] = ()) -> None:
        """Append a row at a stamp [ns].

        Raises:
            MessageError: A number is infinite or beyond all reason.
        """
        self.extend(checked(Rows([stamp], np.asarray([row], np.float64), names)))

    def extend(self, found: Rows) -> None:
        """Append rows, or only count rows that are not kept."""
        rows = self._layouts.setdefault((found.names, found.values.shape[1:]), _Rows(found.stamps[0]))
        rows.count += len(found.stamps)
        for k, stamp in enumerate(found.stamps):
            if (found.kept is None or found.kept[k]) and (not rows.stamps or stamp > rows.stamps[-1]):
                rows.stamps.append(stamp)
                rows.values.append(found.values[k] if found.kept is None else found.values[k].copy())

    def other_layouts(self) -> Iterator[tuple[int, int, str]]:
        """First stamp [ns], number and description of the rows of each layout other than the layout of the series."""
        main_names, main_shape = self._main_layout
        for (names, shape), rows in self._layouts.items():
            if rows is not self._main:
                expected, found = (main_names, names) if names != main_names else (main_shape, shape)
                yield (
                    rows.first,
                    rows.count,
                    f"expected {_text(expected)} as in most messages, found {_text(found)}; of another scene",
                )

    @property
    def _main_layout(self) -> _Layout:
        return max(self._layouts, key=lambda layout: self._layouts[layout].count, default=((), (0,)))

    @property
    def _main(self) -> _Rows:
        return self._layouts.get(self._main_layout) or _Rows()

    @property
    def stamp(self) -> NDArray[np.int64]:
        """Header stamps [ns], shape (T,)."""
        return np.array(self._main.stamps, np.int64)

    @property
    def time(self) -> Array:
        """Header stamps as time [s], shape (T,)."""
        return self.stamp / NANOSECONDS

    @property
    def values(self) -> Array:
        """The rows, shape (T, ...); read-only."""
        main, (rows, stacked) = self._main, self._stacked
        if rows is not main or len(stacked) != len(main.values):
            stacked = np.array(main.values, np.float64)
            stacked.flags.writeable = False
            self._stacked = main, stacked
        return stacked


def checked(rows: Rows) -> Rows:
    """The rows, if no number is infinite or beyond all reason.

    Raises:
        MessageError: A number is.
    """
    if (np.abs(rows.values) > _LARGEST).any():
        raise MessageError(f"expected numbers within {_LARGEST:g}, found a larger one")
    return rows


def _text(layout: tuple[str, ...] | tuple[int, ...]) -> str:
    """Names, or a shape, for a message."""
    return " x ".join(map(str, layout)) if layout and isinstance(layout[0], int) else ", ".join(map(str, layout))


class Column:
    """Property of a series: one part of each row, shape (T, ...); of shape (0,) where there is no row."""

    def __init__(self, *place: int | slice) -> None:
        self._place = (slice(None), *place)

    def __get__(self, series: Series, owner: type[Series]) -> Array:
        return series.values[self._place] if len(series) else series.values
