# SPDX-License-Identifier: Apache-2.0
"""Machine code on disk: files of this user alone, checked by content hash, written again where damaged.

numba's own cache fails for ever on a damaged index, and runs what another user has put there.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import stat
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

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
        """None is needed: the name of the file says it."""

    @classmethod
    def from_function(cls, _function: Any, file: str) -> _Locator:
        """Locator of a function in a source file."""
        return cls(Path(file))


class _Implementation(_CACHING.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Locator,)


class CheckedFiles:
    """One file for each signature: hash, then key and machine code. No index that processes would share."""

    def __init__(self, folder: Path, base: str, suffix: str = "machine_code") -> None:
        self._folder, self._base, self._suffix = folder, base, suffix

    def path(self, key: Any) -> Path:
        """File of a signature and processor."""
        return self._folder / f"{self._base}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.{self._suffix}"

    def load(self, key: Any) -> Any:
        """Machine code of a signature; None where there is none, or none that can be used."""
        path = self.path(key)
        content = read_own(path)
        if content is None:
            return None
        if hashlib.sha256(content[_HASH:]).digest() == content[:_HASH]:
            with suppress(Exception):  # written by another version in some way
                known, data = pickle.loads(content[_HASH:])  # noqa: S301  of this user, and whole
                if repr(known) == repr(key):
                    return data
        _LOG.warning("%s: damaged, compiled again", path)
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
