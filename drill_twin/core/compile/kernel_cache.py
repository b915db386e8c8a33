# SPDX-License-Identifier: Apache-2.0
"""Cache of compiled kernels on disk, each under a name that changes with its machine code.

numba's own cache checks one file and does not see edits in the functions that it calls. So a small module is written
into the cache folder and named by a hash of every source that it reaches, of the versions and of the processor: an
edit gives another name, and stale code is never run. Compilations in this thread are counted, or refused where all is
expected in the cache.
"""

import hashlib
import logging
import platform
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.dispatcher import Dispatcher

from drill_twin.core.compile.jit import is_inlined, start
from drill_twin.core.compile.object_cache import keep_machine_code, keep_parts
from drill_twin.core.compile.source_hash import PACKAGE, PARSED, modules_reached, source_hash
from drill_twin.core.files.kept_files import CheckedFiles, cached_file, permanent_folder
from drill_twin.core.files.output import PRIVATE, write_whole

start()  # numba is imported, so that functions become dispatchers
_LOG = logging.getLogger(__name__)

ONE_THREAD = RLock()
"""One thread makes a module: no other thread may see half a module, and Python 3.11 loses count in two `ast.parse`."""


def load_generated(kind: str, text: str, *more: str, packages: tuple[str, ...] = ()) -> ModuleType:
    """Import a generated module and its cached machine code, under a name that changes with both.

    Args:
        kind: First part of the module's name.
        text: Source of the module.
        more: Texts besides the sources on which the machine code depends, such as the types of arguments.
        packages: Packages besides drill_twin whose source the module uses.
    """
    with ONE_THREAD:
        return _load(f"drill_twin_{kind}_{fingerprint(text, *more, packages=packages)}", text, packages)


def fingerprint(text: str, *more: str, packages: tuple[str, ...] = ()) -> str:
    """Hash of all source that a module reaches, of other texts, of the versions of libraries and of the processor."""
    with ONE_THREAD, _kept_parsing():
        digest = hashlib.sha256(source_hash(text, packages).encode())
    for part in (*more, platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(part.encode())
    cpu = llvmlite.binding
    digest.update(f"{cpu.get_host_cpu_name()} {sorted(cpu.get_host_cpu_features().items())}".encode())
    return digest.hexdigest()[:16]


@contextmanager
def _kept_parsing() -> Iterator[None]:
    """Context that has the parsed sources of earlier processes, and keeps the sources that are parsed in it."""
    folder = permanent_folder()
    if folder is None:
        yield
        return
    method = hashlib.sha256(Path(__file__).with_name("source_hash.py").read_bytes()).hexdigest()
    key, file = (
        (platform.python_version(), __file__, method),
        CheckedFiles(folder, "sources", "parsed", level=logging.DEBUG),
    )
    if not PARSED:
        PARSED.update(file.load(key) or {})
    before = dict(PARSED)
    yield
    if before != PARSED:
        file.save(key, {name: found for name, found in PARSED.items() if Path(name).is_file()})


def _load(name: str, text: str, packages: tuple[str, ...]) -> ModuleType:
    """The module of this name, with the machine code in the cache folder.

    The module's source is kept there for tracebacks and debuggers; the kept file is not run.
    """
    if name in sys.modules:
        return sys.modules[name]
    path = cached_file(f"{name}.py")
    try:
        if not path.is_file() or path.read_bytes() != text.encode():
            write_whole(path, text, PRIVATE)
    except OSError as error:
        _LOG.warning("%s: not kept: %s", path, error.strerror or error)
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    try:
        exec(compile(text, str(path), "exec"), module.__dict__)  # noqa: S102  the text is ours
    except BaseException:
        del sys.modules[name]
        raise
    for value in vars(module).values():
        if isinstance(value, Dispatcher) and value.py_func.__module__ == name and not is_inlined(value):
            foreign = any(package != PACKAGE for package in packages)
            keep_machine_code(value, lambda: _keep_parts(text, packages), allocates=foreign)
    return module


def _keep_parts(text: str, packages: tuple[str, ...]) -> None:
    """Let the functions that a generated module reaches be shared with other modules."""
    folder = permanent_folder()
    if folder is not None:
        modules = [name for name in modules_reached(text, packages) if name in sys.modules]
        keep_parts(modules, folder, lambda name: fingerprint(f"import {name}", packages=packages))


_EVENTS: Any = import_module("numba.core.event")
_LISTENER: Any = _EVENTS.Listener
_COMPILE = "numba:compile"


class NotCachedError(Exception):
    """A function is not in the cache of compiled kernels."""


class _Listener(_LISTENER):  # type: ignore[misc]
    """Calls a function before each compilation in the thread that made it."""

    def __init__(self, started: Callable[[], None]) -> None:
        self._started = started
        self._thread = threading.get_ident()

    def on_start(self, event: Any) -> None:
        """Call the function."""
        del event
        if threading.get_ident() == self._thread:
            self._started()

    def on_end(self, event: Any) -> None:
        """No-op: a compilation is counted when it begins."""


@contextmanager
def before_each_compilation(started: Callable[[], None]) -> Iterator[None]:
    """Context in which a function is called before each function that numba compiles, inlined ones included."""
    listener = _Listener(started)
    _EVENTS.register(_COMPILE, listener)
    try:
        yield
    finally:
        _EVENTS.unregister(_COMPILE, listener)


@contextmanager
def from_cache_only() -> Iterator[None]:
    """Context in which nothing is compiled.

    Raises:
        NotCachedError: A function was called whose machine code is not in the cache.
    """

    def refuse() -> None:
        raise NotCachedError

    with before_each_compilation(refuse):
        yield
