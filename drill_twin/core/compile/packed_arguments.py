# SPDX-License-Identifier: Apache-2.0
"""Nested named tuples of arrays and numbers as memory: packed in one block to save, in words for compiled functions.

Unboxing the two hundred arrays of a twin takes numba longer than several time steps of a short string, and takes code
that is compiled for each set of effects. So compiled code is given one array of words of eight bytes, and reads size,
address, shape and strides of an array where it is used.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.typing import typeof
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from drill_twin.core.arrays import Array, Bytes, Integers

CACHE_LINE = 64
"""Bytes of a cache line, the alignment of each array."""
_WORD = 64  # bits
_INTRINSIC: Any = intrinsic
_INTEGER: Any = types.Integer
_IR: Any = cgutils
_MAKE_ARRAY: Any = make_array
_TUPLE: Any = types.BaseTuple
_TYPEOF: Any = typeof.typeof


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield what nested tuples hold, arrays, numbers and None, each with its dotted name."""
    if not isinstance(value, tuple):
        yield name, value
        return
    for field, item in zip(getattr(value, "_fields", map(str, range(len(value)))), value, strict=True):
        yield from leaves(item, f"{name}.{field}")


def named_arrays(name: str, value: Any) -> Iterator[tuple[str, Array]]:
    """Yield the arrays of nested tuples, each with its dotted name."""
    return ((found, leaf) for found, leaf in leaves(value, name) if isinstance(leaf, np.ndarray))


def rebuilt(change: Callable[..., Any], value: Any, *others: Any) -> Any:
    """Nested tuples as the value, with each leaf changed: `change(leaf, *same_leaf_of_the_others)`."""
    if not isinstance(value, tuple):
        return change(value, *others)
    items = [rebuilt(change, *each) for each in zip(value, *others, strict=True)]
    return type(value)(*items) if hasattr(value, "_fields") else tuple(items)


def pack_arrays(value: Any) -> tuple[Any, Bytes]:
    """Copy a value with every array as a view of one block; returns it and the block, bytes of shape (size,)."""
    sizes = [-(-array.nbytes // CACHE_LINE) * CACHE_LINE for _, array in named_arrays("", value)]
    raw = np.zeros(sum(sizes) + CACHE_LINE, dtype=np.uint8)
    first = -raw.ctypes.data % CACHE_LINE
    block = raw[first : first + sum(sizes)]
    rooms = iter(np.split(block, np.cumsum(sizes)))

    def move(leaf: Any) -> Any:
        if not isinstance(leaf, np.ndarray):
            return leaf
        view = next(rooms)[: leaf.nbytes].view(leaf.dtype).reshape(leaf.shape)
        view[...] = leaf
        return view

    return rebuilt(move, value), block


def replace_numbers(value: Any, before: Any, after: Any) -> Any:
    """Take from `after` what differs between `before` and `after`, tuples as the value is; arrays change in place."""

    def replaced(own: Any, old: Any, new: Any) -> Any:
        if not isinstance(own, np.ndarray):
            return new
        same = (old == new) | (np.isnan(old) & np.isnan(new))  # NaN is memory too: nothing so far
        np.copyto(own, new, where=~same)
        return own

    return rebuilt(replaced, value, before, after)


class Packed(NamedTuple):
    """Packed arguments, whose first two fields are the first arguments of `field`."""

    words: Integers
    kind: Any
    """numba's type of the value, a named tuple."""
    value: Any
    """The value, whose arrays are kept alive here."""


def pack(value: Any, kind: Any = None) -> Packed:
    """Pack a named tuple of nested tuples of arrays, numbers and None; what is not an array is copied.

    Args:
        value: The tuple.
        kind: numba's type of the tuple, where it is known: numba takes longer to find the type than to run a second
            of a short string.
    """
    words = [word for _, leaf in leaves(value) for word in _words(leaf)]
    return Packed(np.array(words, np.int64), kind or _TYPEOF(value), value)


def undispatched(function: Any, *arguments: Any) -> Callable[..., Any]:
    """Machine code of an `entry_kernel` for arguments of these types, compiled or loaded, without numba's dispatcher.

    With a second kernel in the process the dispatcher takes 0.4 ms a call to resolve the types, longer than a frame.
    """
    signature = tuple(map(_TYPEOF, arguments))
    if signature not in function.overloads:
        function.compile(signature)
    entry: Callable[..., Any] = function.overloads[signature].entry_point
    return entry


def bind(function: Any, packed: Packed) -> Callable[[], int]:
    """Bind an `entry_kernel` of packed arguments to them, without numba's dispatcher."""
    return partial(undispatched(function, *packed[:2]), *packed[:2])


def _words(leaf: Any) -> Iterator[int]:
    if isinstance(leaf, np.ndarray):
        yield from (leaf.size, leaf.itemsize, leaf.ctypes.data, *leaf.shape, *leaf.strides)
    elif isinstance(leaf, float):
        yield int(np.float64(leaf).view(np.int64))
    elif leaf is not None:
        yield int(leaf)


@_INTRINSIC(prefer_literal=True)  # type: ignore[untyped-decorator]
def field(_context: Any, words: Any, kind: Any, name: Any) -> Any:
    """Take a field of a packed named tuple, in compiled code: `field(words, kind, "name")`.

    One at a time: an intermediate value of all fields, whose type takes pages of intermediate code, is never made.
    """
    whole = kind.instance_type
    number = whole.fields.index(name.literal_value)
    first = sum(map(_count, whole[:number]))

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array = _MAKE_ARRAY(signature.args[0])(context, builder, args[0])
        columns = iter(range(first, 1 << 30))

        def word() -> Any:
            return builder.load(builder.gep(array.data, [context.get_constant(types.intp, next(columns))]))

        return _load(context, builder, signature.return_type, word)

    return whole[number](words, kind, name), generate


def _count(kind: Any) -> int:
    """Words that a value of a type takes."""
    if isinstance(kind, _TUPLE):
        return sum(map(_count, kind))
    if isinstance(kind, types.Array):
        return 3 + 2 * int(kind.ndim)
    return 0 if isinstance(kind, types.NoneType) else 1


def _load(context: Any, builder: Any, kind: Any, word: Any) -> Any:
    """Value of a type from the next words; arrays are borrowed, without a reference count."""
    if isinstance(kind, _TUPLE):
        return context.make_tuple(builder, kind, [_load(context, builder, item, word) for item in kind])
    if isinstance(kind, types.Array):
        array = _MAKE_ARRAY(kind)(context, builder)
        array.nitems, array.itemsize = word(), word()
        array.data = builder.inttoptr(word(), array.data.type)
        array.shape = _IR.pack_array(builder, [word() for _ in range(kind.ndim)])
        array.strides = _IR.pack_array(builder, [word() for _ in range(kind.ndim)])
        array.meminfo = _IR.get_null_value(array.meminfo.type)
        array.parent = _IR.get_null_value(array.parent.type)
        return array._getvalue()  # noqa: SLF001 - as numba's own modules
    if isinstance(kind, types.NoneType):
        return context.get_dummy_value()
    if isinstance(kind, types.Float):
        return builder.bitcast(word(), context.get_value_type(kind))
    if isinstance(kind, types.Boolean):
        return builder.trunc(word(), context.get_value_type(kind))
    if isinstance(kind, _INTEGER):
        return word() if kind.bitwidth == _WORD else builder.trunc(word(), context.get_value_type(kind))
    raise TypeError(f"expected numbers, arrays and tuples of them, found {kind}")
