# SPDX-License-Identifier: Apache-2.0
"""Size of core and companions, and numbers without a ground, against limits in `pyproject.toml`; in `make check`.

    python .ci/ratchet.py            # a table; exit code 1 if a limit is exceeded

Who raises a limit says why in the commit. Lines of code are counted without blank lines, comments and docstrings, so
that a reason costs nothing; a statement counts one line for each `WIDTH` characters, so that joined lines gain nothing.

A passage is repeated if six or more lines, without blank ones, comments and imports, stand in two places with the same
shape: alike but for names, strings and numbers.

A number of the whirl analysis has a ground if its docstring or comment says what it rests on, as
`python -m drill_twin_evidence.detection.constants` counts.
"""

from __future__ import annotations

import ast
import io
import keyword
import re
import sys
import tokenize
import tomllib
from collections import defaultdict
from itertools import combinations
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WIDTH = 100
"""Characters of a line of code."""
CORE = ROOT / "drill_twin"
COMPANIONS = tuple(sorted(ROOT.glob("companions/*/drill_twin_*")))
PASSAGE = 6
"""Lines of a repeated passage."""
THIN = 5
"""Words and signs from which a line counts; a bracket that closes does not."""
_NO_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING, tokenize.ENDMARKER}
_KINDS = {tokenize.NAME: "", tokenize.OP: "", tokenize.STRING: "text", tokenize.NUMBER: "0"}
TOO_COMMON = 8
"""Places in which a passage is no longer counted, such as a list of arguments that a library asks for."""


def main() -> int:
    """Print what is measured beside its limit; 1 if one is exceeded."""
    limits = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["ratchet"]
    measured = measure()
    print(f"{'':34}{'now':>8}{'limit':>8}")
    exceeded = False
    for name, number in measured.items():
        above = number > limits[name]
        exceeded |= above
        print(f"{name.replace('_', ' '):34}{number:8}{limits[name]:8}{'  exceeded' if above else ''}")
    if exceeded:
        print("make it smaller, or raise the limit in pyproject.toml, [tool.ratchet], and say why in the commit")
        print("a number without a ground: say in the docstring of its name, or in a comment, what it rests on")
    return int(exceeded)


def measure() -> dict[str, int]:
    """Each figure by the name of its limit."""
    texts = {
        path: path.read_text("utf-8")
        for package in (CORE, *COMPANIONS)
        for path in sorted(package.rglob("*"))
        if path.suffix in {".py", ".js", ".html"}
    }
    pages = [text for path, text in texts.items() if path.suffix != ".py"]
    texts = {path: text for path, text in texts.items() if path.suffix == ".py"}
    return {
        "code_lines": sum(map(code_lines, texts.values())) + sum(map(page_lines, pages)),
        "files_of_the_core": sum(path.is_relative_to(CORE) for path in texts),
        "lines_of_the_longest_file": max(text.count("\n") for text in texts.values()),
        "folders_at_the_top": sum((path / "__init__.py").exists() for path in CORE.iterdir()),
        "repeated_passages": repeated({path: _code(text) for path, text in texts.items()}),
        "parameters_of_commands": _parameters(),
        **_without_a_ground(),
    }


def code_lines(text: str) -> int:
    """Lines of code of a Python file: of each statement its characters without blanks, over `WIDTH`."""
    docstrings = {
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    }
    count, length, begin = 0, 0, 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NEWLINE:
            count += 0 if begin in docstrings else -(-length // WIDTH)
            length = 0
        elif token.type not in _NO_CODE:
            begin = begin if length else token.start[0]
            length += len(token.string)
    return count


def page_lines(text: str) -> int:
    """Lines of code of a script or a page, without comments that fill their lines."""
    text = re.sub(r"/\*.*?\*/|<!--.*?-->|^\s*//.*?$", "", text, flags=re.DOTALL | re.MULTILINE)
    return sum(-(-len("".join(line.split())) // WIDTH) for line in text.splitlines())


def repeated(files: dict[Path, list[str]]) -> int:
    """Pairs of places that share a passage; of a longer one only its begin counts.

    Args:
        files: Lines of code of each file.
    """
    places: dict[tuple[str, ...], list[tuple[Path, int]]] = defaultdict(list)
    for path, lines in files.items():
        for begin in range(len(lines) - PASSAGE + 1):
            places[tuple(lines[begin : begin + PASSAGE])].append((path, begin))
    pairs = {
        pair
        for found in places.values()
        if 1 < len(found) <= TOO_COMMON
        for pair in combinations(found, 2)
        if pair[0][0] != pair[1][0] or abs(pair[0][1] - pair[1][1]) >= PASSAGE
    }
    return sum(((a, i - 1), (b, j - 1)) not in pairs for (a, i), (b, j) in pairs)


def _code(text: str) -> list[str]:
    """Shape of each line of code: names, strings and numbers replaced, without comments, imports and docstrings."""
    left_out = {
        number
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
        or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
        for number in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    shapes: dict[int, list[str]] = defaultdict(list)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        line = token.start[0]
        if line not in left_out and token.type in _KINDS:
            is_name = token.type == tokenize.NAME and not keyword.iskeyword(token.string)
            shapes[line].append("name" if is_name else _KINDS[token.type] or token.string)
    return ["".join(shape) for shape in shapes.values() if len(shape) >= THIN]


def _parameters() -> int:
    """Parameters of the commands of core and companions."""
    from drill_twin.cli.app import commands

    return sum(
        len(command.params)
        for _, command in commands()
        if str(getattr(command.callback, "__module__", "")).partition(".")[0]
        in {CORE.name, *(path.name for path in COMPANIONS)}
    )


def _without_a_ground() -> dict[str, int]:
    """Named constants and factors of the whirl analysis that state no ground."""
    from drill_twin_evidence.detection.constants.ground import Ground
    from drill_twin_evidence.detection.constants.literals import counts, literals

    found = counts(literals(CORE / "whirl"))
    constants = found["constants without a ground"]
    return {"constants_without_a_ground": constants, "factors_without_a_ground": found[Ground.NONE] - constants}


if __name__ == "__main__":
    sys.exit(main())
