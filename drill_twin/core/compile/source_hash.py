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


def source_hash(text: str, packages: tuple[str, ...] = ()) -> str:
    """Hash of a module's own text and of every module that it imports, directly or indirectly.

    Args:
        text: Source of the module.
        packages: Top-level packages to follow besides this one: those that bring effects of their own.
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
    """Code and imports of a module's own text."""
    tree = ast.parse(text)
    imports = tuple(_imported(tree, "", followed))
    return _code(tree), imports


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
    return _parsed(path, package, followed, stat.st_mtime_ns, stat.st_size)


@cache
def _parsed(path: Path, package: str, followed: frozenset[str], changed: int, size: int) -> tuple[str, tuple[str, ...]]:
    """Code and imports of a file; time of change and size are keys of the cache only."""
    del changed, size
    if path.suffix != ".py":  # an extension module
        return hashlib.sha256(path.read_bytes()).hexdigest(), ()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return _code(tree), tuple(_imported(tree, package, followed))


def _code(tree: ast.Module) -> str:
    """The code without docstrings."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [one for one in node.body if not _is_text(one)]
    return ast.dump(tree)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _imported(tree: ast.Module, package: str, followed: frozenset[str]) -> Iterator[str]:
    """Modules of the followed packages that a module of a package imports."""
    for node in _executed(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            origin = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            names = [_module_of(origin, alias.name) for alias in node.names]
        else:
            continue
        yield from (name for name in names if name.partition(".")[0] in followed)


def _executed(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those under ``if TYPE_CHECKING:``."""
    children: Iterable[ast.AST] = ast.iter_child_nodes(tree)
    if isinstance(tree, ast.If) and ast.unparse(tree.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}:
        children = tree.orelse
    for node in children:
        yield node
        yield from _executed(node)


def _module_of(package: str, name: str) -> str:
    """Module imported by `from package import name`: a submodule, or the package that defines the name."""
    return f"{package}.{name}" if _path(f"{package}.{name}") else package


@cache
def _path(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None
