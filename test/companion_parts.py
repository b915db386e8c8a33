# SPDX-License-Identifier: Apache-2.0
"""Modules of the companions for tests of the core, which run without these packages too."""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import pytest


class _Absent:
    """Stand-in of a module whose package is not installed: false, and a test that calls a name of it is skipped."""

    def __init__(self, package: str) -> None:
        self._package = package

    def __bool__(self) -> bool:
        return False

    def __getattr__(self, name: str) -> "_Absent":
        return self

    def __call__(self, *_: Any, **__: Any) -> Any:
        pytest.skip(f"needs the package {self._package}")

    __iter__ = __call__


def part(module: str) -> Any:
    """Module of a companion, or its stand-in."""
    package = module.partition(".")[0]
    return import_module(module) if find_spec(package) else _Absent(package)
