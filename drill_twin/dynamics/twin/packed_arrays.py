# SPDX-License-Identifier: Apache-2.0
"""Arrays of nested named tuples: packed in one block of memory, which a single copy saves, named, and replaced."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array, Bytes

CACHE_LINE = 64
"""Bytes of a cache line, the alignment of each array."""


def pack_arrays(value: Any) -> tuple[Any, Bytes]:
    """Copy a value with every array as a view of one block; returns it and the block, bytes of shape (size,)."""
    arrays = [array for _, array in named_arrays("", value)]
    starts = np.cumsum([0, *(-(-array.nbytes // CACHE_LINE) * CACHE_LINE for array in arrays)])
    raw = np.zeros(starts[-1] + CACHE_LINE, dtype=np.uint8)
    first = -raw.ctypes.data % CACHE_LINE
    block = raw[first : first + starts[-1]]
    views = iter([_move(array, block[start:]) for array, start in zip(arrays, starts[:-1], strict=True)])
    return _replace_arrays(value, views), block


def named_arrays(name: str, value: object) -> Iterator[tuple[str, Array]]:
    """Yield the arrays of nested named tuples, each with its dotted name."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        for field, item in zip(getattr(value, "_fields", map(str, range(len(value)))), value, strict=True):
            yield from named_arrays(f"{name}.{field}", item)


def replace_numbers(value: Any, before: Any, after: Any) -> Any:
    """Take from `after` what differs between `before` and `after`, tuples as the value is; arrays change in place."""
    if isinstance(value, np.ndarray):
        same = (before == after) | (np.isnan(before) & np.isnan(after))  # NaN is memory too: nothing so far
        np.copyto(value, after, where=~same)
        return value
    if not isinstance(value, tuple):
        return after
    return _rebuilt(value, [replace_numbers(*trio) for trio in zip(value, before, after, strict=True)])


def _rebuilt(value: Any, items: list[Any]) -> Any:
    return type(value)(*items) if hasattr(value, "_fields") else tuple(items)


def _move(array: Array, room: Bytes) -> Array:
    view: Array = room[: array.nbytes].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


def _replace_arrays(value: Any, views: Iterator[Array]) -> Any:
    if isinstance(value, np.ndarray):
        return next(views)
    if not isinstance(value, tuple):
        return value
    return _rebuilt(value, [_replace_arrays(item, views) for item in value])
