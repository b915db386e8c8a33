# SPDX-License-Identifier: Apache-2.0
"""Arguments of a compiled function in one array of words, unpacked by the function itself.

Unboxing the two hundred arrays of a twin takes numba longer than several time steps of a short string, and code that is
compiled for each set of effects. So they are packed once, into words of eight bytes; compiled code reads size, address,
shape and strides of an array where it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.typing import typeof
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from drill_twin.core.arrays import Integers

_WORD = 64  # bits
_INTRINSIC: Any = intrinsic
_INTEGER: Any = types.Integer
_IR: Any = cgutils
_MAKE_ARRAY: Any = make_array
_TUPLE: Any = types.BaseTuple
_TYPEOF: Any = typeof.typeof


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
        kind: numba's type of it, where it is known: to find it takes longer than a second of a short string.
    """
    return Packed(np.array(list(_words(value)), np.int64), kind or _TYPEOF(value), value)


def bind(function: Any, packed: Packed) -> Callable[[], int]:
    """Bind an `entry_kernel` of packed arguments to them: compiled or loaded, without numba's dispatcher."""
    signature = tuple(map(_TYPEOF, packed[:2]))
    if signature not in function.overloads:
        function.compile(signature)
    return partial(function.overloads[signature].entry_point, packed.words, packed.kind)


def _words(value: Any) -> Iterator[int]:
    if isinstance(value, tuple):
        for item in value:
            yield from _words(item)
    elif isinstance(value, np.ndarray):
        yield from (value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)
    elif isinstance(value, float):
        yield int(np.float64(value).view(np.int64))
    elif value is not None:
        yield int(value)


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
