# SPDX-License-Identifier: Apache-2.0
"""Variants of a test: some with each commit, more in the long run, all of them each night."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest

LONG, NIGHTLY = pytest.mark.long, pytest.mark.nightly


def one_of(every: int, values: Iterable[Any]) -> list[Any]:
    """Values of `parametrize`: one of so many has no mark, the first among them, as many are long, others nightly."""
    return _marked(values, lambda k: [] if k % every == 0 else [LONG if k % every == 1 else NIGHTLY])


def long_one_of(every: int, values: Iterable[Any], *, short: int = 0) -> list[Any]:
    """Values of `parametrize`, of which one of so many is marked long, the first one among them, the others nightly.

    Args:
        every: So many.
        values: A value each, or a tuple of one for each name.
        short: So many of the first ones are not marked: they run with each commit.
    """
    return _marked(values, lambda k: [] if k < short else [NIGHTLY if (k - short) % every else LONG])


def _marked(values: Iterable[Any], marks: Callable[[int], list[pytest.MarkDecorator]]) -> list[Any]:
    parts = [value if isinstance(value, tuple) else (value,) for value in values]
    return [pytest.param(*part, marks=marks(k)) for k, part in enumerate(parts)]
