# SPDX-License-Identifier: Apache-2.0
"""All that a twin remembers lies in one block."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.compile.packed_arguments import CACHE_LINE, named_arrays, pack_arrays
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import load_scene


class Inner(NamedTuple):
    numbers: np.ndarray
    count: int


class Outer(NamedTuple):
    inner: Inner
    places: np.ndarray
    nothing: np.ndarray


def test_arrays_move_with_their_content_and_everything_else_stays():
    value = Outer(Inner(np.arange(6.0).reshape(2, 3).T, 7), np.array([3, 4]), np.zeros((0, 2)))
    moved, block = pack_arrays(value)
    assert moved.inner.count == 7
    for (name, here), (same, there) in zip(named_arrays("", value), named_arrays("", moved), strict=True):
        assert name == same
        assert here.dtype == there.dtype
        assert there.flags.c_contiguous
        np.testing.assert_array_equal(here, there)
    assert moved.inner.numbers.ctypes.data % CACHE_LINE == 0
    before = block.copy()
    moved.inner.numbers[0, 0], moved.places[1] = -1.0, 9
    assert (block != before).any()
    block[:] = before
    assert moved.inner.numbers[0, 0] == 0.0
    assert moved.places[1] == 4


def test_every_array_of_a_checkpoint_is_a_part_of_it():
    twin = Twin(load_scene("pa6_bench"))
    twin.dynamics.memory_block[:] = 255
    for name, array in twin.checkpoint().items():
        assert name == "guard" or (array.view(np.uint8) == 255).all(), name
