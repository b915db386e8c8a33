# SPDX-License-Identifier: Apache-2.0
"""The public Python API, re-exported by `drill_twin`: scenes, runs, results, analysis (docs/api.md).

The names are in `__init__.pyi`, where type checkers look for them; each is loaded on first use, so that what needs one
of them does not load them all. Names of a companion package that is not installed are refused with its name.
"""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from drill_twin.core.companions import not_installed

_PLACES = {
    imported.name: statement.module or ""
    for statement in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body
    if isinstance(statement, ast.ImportFrom)
    for imported in statement.names
}

_ABSENT = {place for place in {module.partition(".")[0] for module in _PLACES.values()} if find_spec(place) is None}
"""Companion packages that are not installed."""
__all__ = sorted(name for name, place in _PLACES.items() if place.partition(".")[0] not in _ABSENT)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Load a name of the API on first use."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if (package := _PLACES[name].partition(".")[0]) in _ABSENT:
        raise not_installed(f"drill_twin.{name}", package)
    value = globals()[name] = getattr(import_module(_PLACES[name]), name)
    return value


def __dir__() -> list[str]:
    """Names of the API, loaded or not."""
    return sorted({*globals(), *__all__})
