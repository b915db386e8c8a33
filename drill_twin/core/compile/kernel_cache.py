# SPDX-License-Identifier: Apache-2.0
"""Cache of compiled kernels on disk, each under a name that changes with its machine code.

numba's own cache checks one file and does not see edits in the functions that it calls. So a small module is written
into the cache folder and named by a hash of every source that it reaches, of the versions and of the processor: an
edit gives another name, and stale code is never run. Compilations in this thread are counted, or refused where all is
expected in the cache.
"""

import hashlib
import logging
import os
import platform
import stat
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
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
from drill_twin.core.compile.object_cache import CheckedFiles, is_open, keep_machine_code, keep_parts
from drill_twin.core.compile.source_hash import PARSED, modules_reached, source_hash
from drill_twin.core.errors import RunError
from drill_twin.core.files.output import PRIVATE, write_whole

start()  # numba is imported, so that functions become dispatchers
_LOG = logging.getLogger(__name__)

ONE_THREAD = RLock()
"""One thread makes a module: no other thread may see half a module, and Python 3.11 loses count in two `ast.parse`."""


def cache_folder() -> Path:
    """Folder of compiled kernels: the permanent folder, else a temporary folder.

    Raises:
        RunError: The folder named by ``$DRILL_TWIN_CACHE`` cannot be made, or belongs to another user.
    """
    return permanent_folder() or _temporary_folder()


def cached_file(name: str) -> Path:
    """File of the cache: the kept file, even in a folder that cannot be written to; else the path for a new file.

    Raises:
        RunError: As `cache_folder`.
    """
    kept = _kept_folder()
    return kept / name if kept and (kept / name).is_file() else cache_folder() / name


def permanent_folder() -> Path | None:
    """Folder shared by the processes of this user, if it can be written to.

    Raises:
        RunError: As `cache_folder`.
    """
    kept = _kept_folder()
    return kept if kept and os.access(kept, os.W_OK) else None


def _kept_folder() -> Path | None:
    """``$DRILL_TWIN_CACHE``, else the folder in the user's cache folder; None where no folder can be trusted.

    Files in the folder are run as programs: only this user, or only root, may write to the folder.
    """
    named = os.environ.get("DRILL_TWIN_CACHE")
    folder = Path(named) if named else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "drill_twin"
    try:
        folder.mkdir(mode=stat.S_IRWXU, parents=True, exist_ok=True)
        if folder.stat().st_uid == os.geteuid() and stat.S_IMODE(folder.stat().st_mode) & ~stat.S_IRWXU:
            with suppress(OSError):  # on a disk that is mounted read-only
                folder.chmod(folder.stat().st_mode & stat.S_IRWXU)
        found = folder.stat()
        if found.st_uid not in {os.geteuid(), 0}:
            reason = f"a folder of user {found.st_uid}, who could put programs there"
        elif is_open(found):
            reason = "a folder in which other users could put programs"
        else:
            return folder
    except OSError as error:
        reason = error.strerror or str(error)
    if named:
        raise RunError(
            f"DRILL_TWIN_CACHE: expected a folder of your own that can be written to, found {named}: {reason}; "
            "name another, or unset it"
        )
    return None


@cache
def _temporary_folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="drill_twin_kernels_"))


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
    key, file = (platform.python_version(), __file__, method), CheckedFiles(folder, "sources", "parsed", logging.DEBUG)
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
    import_array_functions()
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
            keep_machine_code(value, lambda: _keep_parts(text, packages))
    return module


def _keep_parts(text: str, packages: tuple[str, ...]) -> None:
    """Let the functions that a generated module reaches be shared with other modules."""
    folder = permanent_folder()
    if folder is not None:
        modules = [name for name in modules_reached(text, packages) if name in sys.modules]
        keep_parts(modules, folder, lambda name: fingerprint(f"import {name}", packages=packages))


@cache
def import_array_functions() -> None:
    """Import `numba.np.arraymath` without scipy, which takes a fifth of the start of a short run.

    On import, numba asks whether scipy's BLAS is there. Only functions that use BLAS need to know, and such functions
    ask again when they are compiled.
    """
    linalg: Any = import_module("numba.np.linalg")
    ensure_blas = getattr(linalg, "ensure_blas", _no_question)
    linalg.ensure_blas = _no_question
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ensure_blas


def _no_question() -> None:
    """Stands in for `ensure_blas` during the import."""


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
