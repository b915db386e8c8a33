# SPDX-License-Identifier: Apache-2.0
"""Ground of a numeric literal, as its docstring or comment states it: read by words, which can be wrong.

A count by words tells how many numbers state a ground, not how many grounds are right; who reads the table judges.
"""

from __future__ import annotations

import ast
import re
from enum import StrEnum


class Ground(StrEnum):
    """Ground that a docstring or comment states; the first that applies."""

    MEASURED = "measured"
    """A command, a test, or seeds on which the number was found or judged."""
    SOURCE = "source"
    """A publication, a standard, a theorem."""
    CHOSEN = "chosen"
    """It says that the number was chosen, or not measured."""
    DERIVED = "derived"
    """A reason: a formula, a consequence of a definition, a bound of what uses it."""
    FILE = "chosen, says the file"
    """The words of a constant state nothing; its file says that all such constants were chosen."""
    NONE = "none"


_NOT_MEASURED = re.compile(r"(?i:\bno|\bnot)\b[^.;]{0,60}\bmeasured( by (itself|themselves))?")
_WORDS = {
    Ground.MEASURED: r"python -m|drill-twin |`make |`test|\bseeds\b|evidence/|\bmeasured\b|random runs",
    Ground.SOURCE: r"\b(19|20)\d\d\b|\bAPI \d|\bSPE\b|Nyquist|Descartes|\bISO \d|Student",
    Ground.CHOSEN: r"\b[Cc]hosen\b",
    Ground.DERIVED: (
        r"\bfollows? from\b|derivation|\bby (its |the )?definition\b|definition alone|\bdefines\b"
        r"|part of the definition"
        r"|\bso that\b|\bbecause\b|\bsum of\b|\b(which|whose|an? \w+) needs\b|\bneeds (a|four|them|\w+ before)\b"
        r"|\b(as|for|of|within) `[a-z_.]*[A-Z_]{4,}`,? (holds|gives|with|within which|and)|\bthree numbers\b"
        r"|\bprobability\b|\bonce in\b|standard deviation\w* by noise|cannot be told|cannot tell|are told from"
        r"|\bshortens?\b|\bkeeps \d|would look like|as wide as|swept some|\bless a margin|\bis round-off\b"
        r"|\btwo periods\b|integral of|differs? by less|\btriangle|coefficients? of|\bfar (below|beyond|above)\b"
        r"|sweeps less|does not suffice|\bmakes? no\b|formula|expansion|bytes|memory is bounded|the history holds"
    ),
}  # fmt: skip
_OF_THE_FILE = re.compile(
    r"(numbers?|constants?) of this file (was|were) chosen|(below|file) that states no reason was"
)


def ground_of(source: str, line: int, value: complex, chain: list[ast.AST], *, named: bool) -> Ground:
    """Ground of a literal.

    Args:
        source: Text of its file.
        line: Its line, from 1.
        value: Its number.
        chain: The nodes that hold it, from the nearest on.
        named: True for a constant with a name, whose docstring follows it. Any other number has the comment of its
            line, and the docstring of its function where that holds the number.
    """
    lines = source.splitlines()
    said = lines[line - 1].partition("  # ")[2]
    if named:
        said += " " + _docstring_after(chain)
    else:
        said += " " + " ".join(text for text in _docstrings(chain) if _holds(text, value))
    found = stated(said)
    if found is Ground.NONE and named and _OF_THE_FILE.search(" ".join(source.split())):
        return Ground.FILE
    return found


def stated(text: str) -> Ground:
    """Ground that a text states."""
    text = " ".join(text.split())
    claims = _NOT_MEASURED.sub("chosen", text)
    return next((ground for ground, words in _WORDS.items() if re.search(words, claims)), Ground.NONE)


def _docstring_after(chain: list[ast.AST]) -> str:
    """Text that follows the statement of a constant."""
    statement = next(node for node in chain if isinstance(node, ast.stmt))
    body: list[ast.stmt] = getattr(chain[chain.index(statement) + 1], "body", [])
    if statement not in body:
        return ""
    after = body[body.index(statement) + 1 : body.index(statement) + 2]
    if after and isinstance(after[0], ast.Expr) and isinstance(after[0].value, ast.Constant):
        return str(after[0].value.value)
    return ""


def _docstrings(chain: list[ast.AST]) -> list[str]:
    return [ast.get_docstring(node) or "" for node in chain if isinstance(node, ast.FunctionDef | ast.ClassDef)]


def _holds(text: str, value: complex) -> bool:
    number = f"{abs(value):g}"
    return bool(re.search(rf"(?<![\w.]){re.escape(number)}(?![\w.]*\d)", text))
