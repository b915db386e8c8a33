# SPDX-License-Identifier: Apache-2.0
"""Machine code on disk: files of this user alone, checked by content hash, written again where damaged.

numba's own cache fails for ever on a damaged index, and runs what another user has put there.

Most functions of a kernel do not depend on the set of effects. Each is kept as bitcode, under a name that changes with
every source that its module reaches, with the types of its arguments, the versions and the processor; so a kernel of
another set types and lowers the loop around the effects only.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import stat
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from numba import types
from numba.core.dispatcher import Dispatcher

from drill_twin.core.compile.inlined_compiler import inlined_parts, lasting_name, restore_inlined, type_text
from drill_twin.core.compile.jit import is_inlined
from drill_twin.core.files.output import PRIVATE, write_whole

_CACHING: Any = import_module("numba.core.caching")
_HASH = hashlib.sha256().digest_size
_LOG = logging.getLogger(__name__)


def is_open(found: os.stat_result) -> bool:
    """True for a file or folder that others than its owner can write to."""
    return bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def read_own(path: Path) -> bytes | None:
    """Content of a file that only this user, or only root, can write; None if there is none, which is logged."""
    try:
        with path.open("rb") as stream:
            found = os.fstat(stream.fileno())
            if found.st_uid in {os.geteuid(), 0} and not is_open(found):
                return stream.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        _LOG.warning("%s: cannot be read (%s), made again", path, error.strerror or error)
        return None
    _LOG.warning("%s: of another user, or writable by others; not used, made again", path)
    return None


def keep_machine_code(dispatcher: Any, before_compilation: Callable[[], None]) -> None:
    """Let a function of numba keep its machine code beside its source file; call something before it is compiled."""
    dispatcher._cache = _Cache(dispatcher.py_func, before_compilation)  # noqa: SLF001  as its `enable_caching` does


class _Locator(_CACHING._CacheLocator):  # type: ignore[misc]  # noqa: SLF001
    """The folder of the source file."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def ensure_cache_path(self) -> None:
        """No-op: the folder was made with the source file."""

    def get_cache_path(self) -> str:
        """Folder of the files."""
        return str(self._file.parent)

    def get_source_stamp(self) -> str:
        """Name of the source file, which changes with its content."""
        return self._file.stem

    def get_disambiguator(self) -> None:
        """None, as the name of the file changes with its content."""

    @classmethod
    def from_function(cls, _function: Any, file: str) -> _Locator:
        """Locator of a function in a source file."""
        return cls(Path(file))


class _Implementation(_CACHING.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Locator,)


class CheckedFiles:
    """One file for each signature: hash, then key and machine code. No index that processes would share."""

    def __init__(self, folder: Path, base: str, suffix: str = "machine_code", level: int = logging.WARNING) -> None:
        self._folder, self._base, self._suffix, self._level = folder, base, suffix, level

    def path(self, key: Any) -> Path:
        """File of a signature and processor."""
        return self._folder / f"{self._base}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.{self._suffix}"

    def load(self, key: Any) -> Any:
        """Machine code of a signature; None where no file of it can be used."""
        path = self.path(key)
        content = read_own(path)
        if content is None:
            return None
        if hashlib.sha256(content[_HASH:]).digest() == content[:_HASH]:
            with suppress(Exception):  # written by another version in some way
                known, data = pickle.loads(content[_HASH:])  # noqa: S301  of this user, and whole
                if repr(known) == repr(key):
                    return data
        _LOG.log(self._level, "%s: damaged, compiled again", path)
        return None

    def save(self, key: Any, data: Any) -> None:
        """Save the machine code of a signature, if there is room."""
        content = _CACHING.dumps((key, data))
        path = self.path(key)
        try:
            write_whole(path, hashlib.sha256(content).digest() + content, PRIVATE)
        except OSError as error:
            _LOG.warning("%s: compiled, but not kept: %s", path, error.strerror or error)


class _Cache(_CACHING.FunctionCache):  # type: ignore[misc]
    _impl_class = _Implementation

    def __init__(self, function: Any, before_compilation: Callable[[], None]) -> None:
        super().__init__(function)
        self._cache_file = CheckedFiles(Path(self._cache_path), self._impl.filename_base)
        self._before_compilation = before_compilation

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature; None where it has to be compiled."""
        found = super().load_overload(sig, target_context)
        if found is None:
            self._before_compilation()
        return found


Fingerprint = Callable[[str], str]
"""Hash of all that the code of a module depends on, by its name."""


def keep_parts(modules: Iterable[str], folder: Path, fingerprint: Fingerprint) -> None:
    """Let the inlined functions of imported modules keep their bitcode in a folder.

    Functions that are bound to other functions are not kept: they belong to one set of effects.
    """
    known = cache(fingerprint)
    for name in modules:
        found: list[Any] = [value for value in vars(sys.modules[name]).values() if isinstance(value, Dispatcher)]
        for value in filter(is_inlined, found):
            function = value.py_func
            if function.__module__ == name and lasting_name(function):
                value._cache = _KeptPart(function, folder, known)  # noqa: SLF001  as its `enable_caching` does


class _KeptPart(_CACHING.NullCache):  # type: ignore[misc]
    """The cache of one function, as numba's dispatcher asks for it."""

    def __init__(self, function: Any, folder: Path, fingerprint: Fingerprint) -> None:
        self._function, self._folder, self._fingerprint = function, folder, fingerprint

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function for a signature; None where it is not kept, or cannot be used."""
        found = self._files().load(self._key(sig)) if _is_shared(sig) else None
        return None if found is None else restore_inlined(target_context, found)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the compiled function for a signature."""
        if _is_shared(sig) and not data.library.has_dynamic_globals:
            self._files().save(self._key(sig), inlined_parts(data))

    def _key(self, sig: Any) -> str:
        return f"{lasting_name(self._function)}({type_text(sig)})"

    def _files(self) -> CheckedFiles:
        module = self._function.__module__
        base = f"part_{module}.{self._function.__name__}_{self._fingerprint(module)}"
        return CheckedFiles(self._folder, base, "bitcode")


def _is_shared(argument_types: Any) -> bool:
    """Check that types mean the same in every process: no class of a generated module, no function as an argument."""
    classes = [one.instance_class for one in argument_types if hasattr(one, "instance_class")]
    modules = [sys.modules.get(found.__module__) for found in classes]
    generated = any(module is None or module.__spec__ is None for module in modules)
    return not generated and not any(isinstance(one, types.Callable) for one in argument_types)
