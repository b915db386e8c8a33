# SPDX-License-Identifier: Apache-2.0
"""Variants of a test: some with each commit, all of them in the long run."""

from collections.abc import Iterable
from typing import Any

import pytest


def one_of(every: int, values: Iterable[Any]) -> list[Any]:
    """Values of `parametrize`, of which one of so many is not marked long, the first one among them."""
    parts = [value if isinstance(value, tuple) else (value,) for value in values]
    return [pytest.param(*part, marks=[pytest.mark.long] if k % every else []) for k, part in enumerate(parts)]
