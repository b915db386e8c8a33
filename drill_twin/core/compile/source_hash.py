# SPDX-License-Identifier: Apache-2.0
"""Hash of all source code that a generated module can reach, computed from its imports.

Comments, docstrings and layout do not enter, so a change of them recompiles nothing. Libraries (numba, numpy) enter by
version, in `drill_twin.core.compile.kernel_cache`.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterable, Iterator
from functools import cache, lru_cache
from pathlib import Path

PACKAGE = "drill_twin"
Import = tuple[str, str]
"""Module, and the name imported from it; "" where the module itself is imported."""
PARSED: dict[str, tuple[str, str, tuple[Import, ...]]] = {}
"""File -> hash of its content, hash of its code, imports: to parse all files takes a second, to read them 10 ms."""


def source_hash(text: str, packages: tuple[str, ...] = ()) -> str:
    """Hash of a module's own text and of every module that it imports, directly or indirectly.

    Args:
        text: Source of the module.
        packages: Top-level packages to follow besides drill_twin: packages that bring effects of their own.
    """
    digest = hashlib.sha256(_of_text(text, _followed(packages))[0].encode())
    for name, content in sorted(_reached(text, packages).items()):
        digest.update(f"{name}\n{content}".encode())
    return digest.hexdigest()


def modules_reached(text: str, packages: tuple[str, ...] = ()) -> list[str]:
    """Names of the modules whose source enters `source_hash`, sorted."""
    return sorted(_reached(text, packages))


def _followed(packages: tuple[str, ...]) -> frozenset[str]:
    return frozenset((PACKAGE, *packages))


@lru_cache(maxsize=256)  # each member of an ensemble asks for the same
def _of_text(text: str, followed: frozenset[str]) -> tuple[str, tuple[str, ...]]:
    """Hash of the code of a module's own text, and its imports."""
    code, imports = _parsed(text, "")
    return code, tuple(_modules(imports, followed))


def _reached(text: str, packages: tuple[str, ...]) -> dict[str, str]:
    followed = _followed(packages)
    found: dict[str, str] = {}
    waiting = list(_of_text(text, followed)[1])
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name], imports = _read(name, followed)
            waiting += imports
    return found


def _read(name: str, followed: frozenset[str]) -> tuple[str, tuple[str, ...]]:
    path = _path(name)
    if path is None:
        raise ImportError(f"expected the module {name} as a source file, found none; reinstall its package")
    stat = path.stat()
    package = name if path.stem == "__init__" else name.rpartition(".")[0]
    return _of_file(path, package, followed, stat.st_mtime_ns, stat.st_size)


@cache
def _of_file(
    path: Path, package: str, followed: frozenset[str], changed: int, size: int
) -> tuple[str, tuple[str, ...]]:
    """Hash of the code of a file, and its imports; time of change and size are keys of the cache only."""
    del changed, size
    content = path.read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if path.suffix != ".py":  # an extension module
        return found, ()
    if (known := PARSED.get(str(path))) is None or known[0] != found:
        known = PARSED[str(path)] = found, *_parsed(content.decode(), package)
    return known[1], tuple(_modules(known[2], followed))


def _parsed(text: str, package: str) -> tuple[str, tuple[Import, ...]]:
    """Hash of the code of a module's text, and its imports in their order."""
    tree = ast.parse(text)
    imports = tuple(_imported(tree, package))
    return hashlib.sha256(_code(tree).encode()).hexdigest(), imports


def _code(tree: ast.Module) -> str:
    """The code without docstrings."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [one for one in node.body if not _is_text(one)]
    return ast.dump(tree)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _imported(tree: ast.Module, package: str) -> Iterator[Import]:
    """Modules that a module of a package imports, and names that it imports from a module."""
    for node in _executed(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            yield from ((origin, alias.name) for alias in node.names)


def _modules(imports: Iterable[Import], followed: frozenset[str]) -> Iterator[str]:
    """Modules of the followed packages among the imports; a name is a submodule, or its package defines it."""
    for origin, name in imports:
        if origin.partition(".")[0] in followed:
            yield f"{origin}.{name}" if name and _path(f"{origin}.{name}") else origin


def _executed(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes but the nodes under ``if TYPE_CHECKING:``."""
    children: Iterable[ast.AST] = ast.iter_child_nodes(tree)
    if isinstance(tree, ast.If) and ast.unparse(tree.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}:
        children = tree.orelse
    for node in children:
        yield node
        yield from _executed(node)


@cache
def _path(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None
