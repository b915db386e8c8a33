# SPDX-License-Identifier: Apache-2.0
"""Numeric literals of a folder, found in the syntax tree wherever they stand, but for 0, 1 and 2 of either sign.

Every literal is counted. `Use` tells the literals which are no choice (an index, a code, a unit, a shape, a number in a
printed text, a guard against a division by zero) from the literals which are: constants with a name, and factors.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from drill_twin_evidence.detection.constants.ground import Ground, ground_of

COMMON = (0, 1, 2)
"""Numbers that are not counted."""
UNITS = (1e-9, 1e9, 100.0)
"""Factors of nanoseconds and of a share in percent."""
GUARD = 1e-100
"""A smaller number keeps a quotient finite."""
_SHAPES = {"array", "columns", "empty", "full", "ones", "zeros", "reshape"}


class Use(StrEnum):
    """Use of a literal; the first that applies."""

    CODE = "code"
    """Number of a state, in an enumeration or in `A, B, C = range(3)`."""
    TEXT = "text"
    """Stands in an f-string, and is printed only."""
    INDEX = "index"
    """Integer in the brackets of a subscript."""
    SHAPE = "shape"
    """Integer in a call that makes or reshapes an array."""
    UNIT = "unit"
    """Factor that converts a unit, or the imaginary unit."""
    GUARD = "guard"
    """Keeps a quotient finite."""
    CONSTANT = "constant"
    """Value of a name of a module or class, also one of several."""
    FACTOR = "factor"
    """Anywhere else: of a formula, a default argument, an entry of a dictionary in a function."""


CHOICES = (Use.CONSTANT, Use.FACTOR)
"""Uses whose numbers are varied."""


@dataclass(frozen=True)
class Literal:
    """A numeric literal."""

    file: str
    """Path within the folder."""
    line: int
    column: int
    """Place of its first character, lines from 1 and columns from 0."""
    text: str
    """Its characters."""
    value: complex
    """Its number, with the sign that stands before it."""
    name: str
    """Name that it is assigned to, else the function in which it stands."""
    use: Use
    ground: Ground
    """Ground that its docstring or comment states."""

    @property
    def key(self) -> str:
        """File, line and column, which no other literal of the folder has."""
        return f"{self.file}:{self.line}:{self.column}"

    def times(self, factor: float) -> str:
        """Text of the varied number; an integer remains one, and is at least 1."""
        number = ast.literal_eval(self.text)
        return str(max(1, int(number * factor))) if isinstance(number, int) else repr(number * factor)


def literals(folder: Path, under: str = "") -> list[Literal]:
    """Numeric literals of the Python files of a folder, or of a file in it, in their order."""
    files = sorted((folder / under).rglob("*.py")) if (folder / under).is_dir() else [folder / under]
    return [one for file in files for one in _in_file(file, file.relative_to(folder).as_posix())]


def counts(found: Sequence[Literal]) -> dict[str, int]:
    """Literals in all, by use, and of the choices by ground."""
    chosen = [one for one in found if one.use in CHOICES]
    uses, grounds = Counter(one.use for one in found), Counter(one.ground for one in chosen)
    return {
        "all": len(found), "choices": len(chosen), **{use: uses[use] for use in Use},
        **{ground: grounds[ground] for ground in Ground},
        "constants without a ground": sum(one.use is Use.CONSTANT and one.ground is Ground.NONE for one in chosen),
    }  # fmt: skip


def _in_file(file: Path, name: str) -> list[Literal]:
    source = file.read_text("utf-8")
    tree = ast.parse(source)
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
    found = []
    for node in ast.walk(tree):
        if not isinstance(node, ast.Constant):
            continue
        number = node.value
        if isinstance(number, bool) or not isinstance(number, int | float | complex) or number in COMMON:
            continue
        chain = list(_above(node, parents))
        value = -number if isinstance(chain[0], ast.UnaryOp) and isinstance(chain[0].op, ast.USub) else number
        use = _use(node, number, chain)
        text = ast.get_source_segment(source, node) or repr(number)
        found.append(
            Literal(name, node.lineno, node.col_offset, text, value, _name(chain), use,
                    ground_of(source, node.lineno, value, chain, named=use is Use.CONSTANT))
        )  # fmt: skip
    return sorted(found, key=lambda one: (one.line, one.column))


def _above(node: ast.AST, parents: dict[ast.AST, ast.AST]) -> Iterator[ast.AST]:
    """The nodes that hold a node, from the nearest on."""
    while node in parents:
        node = parents[node]
        yield node


def _statement(chain: list[ast.AST]) -> ast.stmt:
    return next(node for node in chain if isinstance(node, ast.stmt))


def _targets(chain: list[ast.AST]) -> str:
    """Names that the statement of a literal assigns in a module or class; empty for any other statement."""
    statement, function = _statement(chain), any(isinstance(node, ast.FunctionDef | ast.Lambda) for node in chain)
    if function or not isinstance(statement, ast.Assign | ast.AnnAssign):
        return ""
    targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
    return ", ".join(ast.unparse(target).strip("()") for target in targets)


def _name(chain: list[ast.AST]) -> str:
    scopes = [node.name for node in chain if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    return ".".join([*reversed(scopes), *filter(None, [_targets(chain)])]) or "module"


def _called(node: ast.AST) -> str:
    called = node.func if isinstance(node, ast.Call) else None
    return called.attr if isinstance(called, ast.Attribute) else called.id if isinstance(called, ast.Name) else ""


def _use(node: ast.AST, number: complex, chain: list[ast.AST]) -> Use:
    statement = _statement(chain)
    owner = next((one for one in chain if isinstance(one, ast.ClassDef)), None)
    unpacked = isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Tuple)
    if (owner and any("Enum" in ast.unparse(base) for base in owner.bases)) or (
        unpacked and _called(chain[0]) == "range" and isinstance(number, int)
    ):
        return Use.CODE
    if any(isinstance(one, ast.JoinedStr) for one in chain):
        return Use.TEXT
    whole = isinstance(number, int)
    inside = chain[: chain.index(statement)]
    if whole and any(
        isinstance(one, ast.Subscript) and one.slice in {node, *inside} and not isinstance(one.slice, ast.Call)
        for one in inside
    ):
        return Use.INDEX
    if whole and any(_called(one) in _SHAPES for one in inside):
        return Use.SHAPE
    if isinstance(number, complex) or (isinstance(chain[0], ast.BinOp) and number in UNITS):
        return Use.UNIT
    if abs(number) < GUARD:
        return Use.GUARD
    return Use.CONSTANT if _targets(chain) else Use.FACTOR
