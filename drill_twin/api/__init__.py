# SPDX-License-Identifier: Apache-2.0
"""The public Python API, re-exported by `drill_twin`: scenes, runs, results, analysis (docs/api.md).

The names are in `__init__.pyi`, where type checkers look for them; each is loaded on first use, so that what needs one
of them does not load them all.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

_PLACES = {
    imported.name: statement.module or ""
    for statement in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body
    if isinstance(statement, ast.ImportFrom)
    for imported in statement.names
}

__all__ = sorted(_PLACES)  # noqa: PLE0605 - the names of the stub, which is what type checkers read


def __getattr__(name: str) -> Any:
    """Load a name of the API on first use."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_PLACES[name]), name)
    return value


def __dir__() -> list[str]:
    """Names of the API, loaded or not."""
    return sorted({*globals(), *__all__})
