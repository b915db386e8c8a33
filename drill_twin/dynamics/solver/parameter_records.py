# SPDX-License-Identifier: Apache-2.0
"""Records of the parameters that one function of an effect reads.

The parameters of all effects of a scene are one named tuple, so each set of effects has a type of its own. A function
that is passed only the fields that it reads is the same for every set, and compiled once for all.
"""

import ast
import inspect
from collections import namedtuple
from functools import cache
from textwrap import dedent
from typing import Any

_SEPARATOR = "__"


@cache
def __getattr__(name: str) -> Any:
    """The class of a record by its name: its fields, joined by two underscores. So it can be pickled."""
    fields = name.split(_SEPARATOR)
    if record_name(tuple(fields)) != name:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return namedtuple(name, fields, module=__name__)  # noqa: PYI024 - its fields have any type


def record_name(fields: tuple[str, ...]) -> str | None:
    """Name of the class of a record; None where it would not tell the fields."""
    name = _SEPARATOR.join(fields)
    usable = all(field.isidentifier() and not field.startswith("_") for field in fields)
    return name if fields and usable and tuple(name.split(_SEPARATOR)) == fields else None


@cache
def fields_read(function: Any) -> tuple[str, ...] | None:
    """Fields that a compiled function reads of its first argument, in the order of the whole record.

    None where it does anything else with that argument, or where its source cannot be had.
    """
    source = getattr(function, "py_func", function)
    try:
        nodes = [*ast.walk(ast.parse(dedent(inspect.getsource(source))))]
    except (OSError, TypeError, SyntaxError):
        return None
    record = source.__code__.co_varnames[0]
    uses = [node for node in nodes if isinstance(node, ast.Name) and node.id == record]
    read = [node.attr for node in nodes if isinstance(node, ast.Attribute) and node.value in uses]
    return None if len(read) < len(uses) else tuple(sorted({*read}, key=lambda name: (name != "drive", name)))
