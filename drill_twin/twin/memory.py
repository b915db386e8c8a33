# SPDX-License-Identifier: Apache-2.0
"""Arrays of nested named tuples, brought into one block of memory: kept and taken back by a single copy."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array, Bytes

LINE = 64
"""Bytes of a cache line, at which each array begins."""


def pack_arrays(value: Any) -> tuple[Any, Bytes]:
    """The same value with every array a view of one block, and the block, bytes of shape (size,)."""
    arrays = [array for _, array in named_arrays("", value)]
    starts = np.cumsum([0, *(-(-array.nbytes // LINE) * LINE for array in arrays)])
    raw = np.zeros(starts[-1] + LINE, dtype=np.uint8)
    first = -raw.ctypes.data % LINE
    block = raw[first : first + starts[-1]]
    views = iter([_moved(array, block[start:]) for array, start in zip(arrays, starts[:-1], strict=True)])
    return _with(value, views), block


def named_arrays(name: str, value: object) -> Iterator[tuple[str, Array]]:
    """Arrays in nested named tuples, each with its dotted name."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        for field, item in zip(getattr(value, "_fields", map(str, range(len(value)))), value, strict=True):
            yield from named_arrays(f"{name}.{field}", item)


def _moved(array: Array, room: Bytes) -> Array:
    view: Array = room[: array.nbytes].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


def _with(value: Any, views: Iterator[Array]) -> Any:
    if isinstance(value, np.ndarray):
        return next(views)
    if not isinstance(value, tuple):
        return value
    items = [_with(item, views) for item in value]
    return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
