# SPDX-License-Identifier: Apache-2.0
"""Inner loops of numpy's functions, for exact kernels.

numpy chooses them for the processor; the last bits of `exp`, `arctan2`, complex products, absolute values and pairwise
sums differ from those of the C library. A kernel that must give what numpy gives calls numpy's own loops, through the
function table of `PyUFuncObject` (part of numpy's C interface since 1.0).

Arrays are of one dimension with any stride, or of several and contiguous.
"""

from __future__ import annotations

import ctypes
from typing import Any

import llvmlite.binding
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.base.exact_jit import exact_kernel

_IR: Any = cgutils
_INTRINSIC: Any = intrinsic
_POINTER, _WORD = ir.IntType(8).as_pointer(), ir.IntType(64)


class _Ufunc(ctypes.Structure):
    """Head of `PyUFuncObject` (numpy/ufuncobject.h)."""

    _fields_ = (
        ("references", ctypes.c_ssize_t),
        ("type", ctypes.c_void_p),
        ("numbers", ctypes.c_int * 4),
        ("functions", ctypes.POINTER(ctypes.c_void_p)),
        ("data", ctypes.POINTER(ctypes.c_void_p)),
    )


def _loop(ufunc: np.ufunc, kinds: str, *, reduce: bool = False) -> Any:
    """Intrinsic that runs a loop of a ufunc: `run(count, *operands)`, with `reduce` `run(count, values, total)`."""
    head, index = _Ufunc.from_address(id(ufunc)), ufunc.types.index(kinds)
    symbol = f"drill_twin_numpy_{ufunc.__name__}_{kinds.replace('->', '_')}"
    address, data = head.functions[index], head.data[index]
    llvmlite.binding.add_symbol(symbol, address)
    if data:
        llvmlite.binding.add_symbol(f"{symbol}_data", data)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        operands = []
        for kind, value in zip(signature.args[1:], args[1:], strict=True):
            array = context.make_array(kind)(context, builder, value)
            operands.append((array.data, _IR.unpack_tuple(builder, array.strides)[-1]))
        if reduce:
            values, total = operands[0], (operands[1][0], _WORD(0))
            operands = [total, values, total]
        pointers = _IR.alloca_once(builder, _POINTER, size=len(operands))
        strides = _IR.alloca_once(builder, _WORD, size=len(operands))
        count = _IR.alloca_once_value(builder, args[0])
        for place, (pointer, stride) in enumerate(operands):
            at = [ir.IntType(32)(place)]
            builder.store(builder.bitcast(pointer, _POINTER), builder.gep(pointers, at))
            builder.store(stride, builder.gep(strides, at))
        pointer_type = ir.FunctionType(ir.VoidType(), [_POINTER.as_pointer(), *[_WORD.as_pointer()] * 2, _POINTER])
        function = _IR.get_or_insert_function(builder.module, pointer_type, symbol)
        told = _POINTER(None)
        if data:
            name = f"{symbol}_data"
            known = builder.module.globals.get(name)
            told = known or ir.GlobalVariable(builder.module, ir.IntType(8), name)
        builder.call(function, [pointers, count, strides, told])
        return context.get_dummy_value()

    def unary(_context: Any, _count: Any, one: Any, out: Any) -> Any:
        return types.void(types.int64, one, out), codegen

    def binary(_context: Any, _count: Any, one: Any, other: Any, out: Any) -> Any:
        return types.void(types.int64, one, other, out), codegen

    return _INTRINSIC(unary if ufunc.nin == 1 or reduce else binary)


_exp, _phasor = _loop(np.exp, "d->d"), _loop(np.exp, "D->D")
_cos, _sin, _arctan2 = _loop(np.cos, "d->d"), _loop(np.sin, "d->d"), _loop(np.arctan2, "dd->d")
_absolute, _hypot = _loop(np.absolute, "D->d"), _loop(np.hypot, "dd->d")
_product, _quotient = _loop(np.multiply, "DD->D"), _loop(np.divide, "DD->D")
_remainder, _square = _loop(np.remainder, "dd->d"), _loop(np.square, "D->D")
_sum, _complex_sum = _loop(np.add, "dd->d", reduce=True), _loop(np.add, "DD->D", reduce=True)


@exact_kernel
def exp(x: Array, out: Array) -> None:
    """Exponential."""
    _exp(out.size, x, out)


@exact_kernel
def complex_exp(z: ComplexArray, out: ComplexArray) -> None:
    """Exponential of complex numbers."""
    _phasor(out.size, z, out)


@exact_kernel
def cos(x: Array, out: Array) -> None:
    """Cosine."""
    _cos(out.size, x, out)


@exact_kernel
def sin(x: Array, out: Array) -> None:
    """Sine."""
    _sin(out.size, x, out)


@exact_kernel
def arctan2(y: Array, x: Array, out: Array) -> None:
    """Angle of points."""
    _arctan2(out.size, y, x, out)


@exact_kernel
def absolute(z: ComplexArray, out: Array) -> None:
    """Absolute value of complex numbers."""
    _absolute(out.size, z, out)


@exact_kernel
def hypot(x: Array, y: Array, out: Array) -> None:
    """Root of the sum of squares."""
    _hypot(out.size, x, y, out)


@exact_kernel
def remainder(x: Array, y: Array, out: Array) -> None:
    """Remainder, of the sign of `y`."""
    _remainder(out.size, x, y, out)


@exact_kernel
def product(one: ComplexArray, other: ComplexArray, out: ComplexArray) -> None:
    """Product of complex numbers."""
    _product(out.size, one, other, out)


@exact_kernel
def quotient(one: ComplexArray, other: ComplexArray, out: ComplexArray) -> None:
    """Quotient of complex numbers."""
    _quotient(out.size, one, other, out)


@exact_kernel
def square(z: ComplexArray, out: ComplexArray) -> None:
    """Square of complex numbers."""
    _square(out.size, z, out)


@exact_kernel
def total(values: Array, out: Array) -> float:
    """Pairwise sum; `out`, shape (1,), is overwritten."""
    out[0] = 0.0
    _sum(values.size, values, out)
    return float(out[0])


@exact_kernel
def complex_total(values: ComplexArray, out: ComplexArray) -> complex:
    """Pairwise sum; `out`, shape (1,), is overwritten."""
    out[0] = 0.0
    _complex_sum(values.size, values, out)
    return complex(out[0])
