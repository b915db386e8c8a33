# SPDX-License-Identifier: Apache-2.0
"""Hash of all source code that a generated module can reach, computed from its imports.

Comments, docstrings and layout do not enter, so a mended sentence recompiles nothing. Libraries (numba, numpy) enter by
version, in `drill_twin.solver.kernel_cache`.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = "drill_twin"


def source_hash(text: str, packages: tuple[str, ...] = ()) -> str:
    """Hash of a module's own text and of every module that it imports, directly or not.

    Args:
        text: Source of the module.
        packages: Top-level packages to follow besides this one: those that bring effects of their own.
    """
    digest = hashlib.sha256(_meaning(ast.parse(text)).encode())
    for name, content in sorted(_reached(text, packages).items()):
        digest.update(f"{name}\n{content}".encode())
    return digest.hexdigest()


def modules_reached(text: str, packages: tuple[str, ...] = ()) -> list[str]:
    """Names of the modules whose source enters `source_hash`, sorted."""
    return sorted(_reached(text, packages))


def _reached(text: str, packages: tuple[str, ...]) -> dict[str, str]:
    followed = frozenset((PACKAGE, *packages))
    found: dict[str, str] = {}
    waiting = list(_imported(ast.parse(text), followed))
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
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    return _parsed(path, package, stat.st_mtime_ns, stat.st_size, followed)


@cache
def _parsed(path: Path, package: str, changed: int, size: int, followed: frozenset[str]) -> tuple[str, tuple[str, ...]]:
    """Code and imports of a file of a package; time of the last change and size are only keys of the cache."""
    del changed, size
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return _meaning(tree), tuple(_imported(tree, followed, package))


def _meaning(tree: ast.Module) -> str:
    """The code without docstrings."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [one for one in node.body if not _is_text(one)]
    return ast.dump(tree)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _imported(tree: ast.Module, followed: frozenset[str], package: str = "") -> Iterator[str]:
    """Modules that a module of a package imports, of the packages that are followed."""
    for node in _statements(tree.body):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            source = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            names = [_module_of(source, alias.name) for alias in node.names]
        else:
            continue
        yield from (name for name in names if name.partition(".")[0] in followed)


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Every statement but those for the type checker only."""
    for node in body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            yield from _statements(node.orelse)
            continue
        yield node
        for field in ("body", "orelse", "finalbody"):
            yield from _statements([one for one in getattr(node, field, []) if isinstance(one, ast.stmt)])


def _module_of(package: str, name: str) -> str:
    """What `from package import name` brings: a submodule, or something defined in the package."""
    return f"{package}.{name}" if package and _path(f"{package}.{name}") else package


@cache
def _path(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None
