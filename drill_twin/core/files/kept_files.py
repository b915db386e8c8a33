# SPDX-License-Identifier: Apache-2.0
"""Results kept on disk for later processes of this user: the folder, and files checked by a hash of their content.

Some of the files are run as programs, so files and folders in which other users could put something are not used.
"""

import hashlib
import logging
import os
import pickle
import stat
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from drill_twin.core.errors import RunError
from drill_twin.core.files.output import PRIVATE, write_whole

_HASH = hashlib.sha256().digest_size
_LOG = logging.getLogger(__name__)


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


class CheckedFiles:
    """One file for each key: hash, then key and data. No index that processes would share.

    Args:
        folder: Folder of the files.
        base: First part of the name of a file.
        suffix: Last part of the name of a file.
        level: Level at which a damaged file is logged.
        dumps: Pickles key and data.
    """

    def __init__(
        self,
        folder: Path,
        base: str,
        suffix: str,
        level: int = logging.WARNING,
        dumps: Callable[[Any], bytes] = pickle.dumps,
    ) -> None:
        self._folder, self._base, self._suffix, self._level, self._dumps = folder, base, suffix, level, dumps

    def path(self, key: Any) -> Path:
        """File of a key."""
        return self._folder / f"{self._base}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.{self._suffix}"

    def load(self, key: Any) -> Any:
        """Data of a key; None where no file of it can be used."""
        path = self.path(key)
        content = read_own(path)
        if content is None:
            return None
        if hashlib.sha256(content[_HASH:]).digest() == content[:_HASH]:
            with suppress(Exception):  # written by another version in some way
                known, data = pickle.loads(content[_HASH:])  # noqa: S301  of this user, and whole
                if repr(known) == repr(key):
                    return data
        _LOG.log(self._level, "%s: damaged, made again", path)
        return None

    def save(self, key: Any, data: Any) -> None:
        """Save the data of a key, if there is room."""
        content = self._dumps((key, data))
        path = self.path(key)
        try:
            write_whole(path, hashlib.sha256(content).digest() + content, PRIVATE)
        except OSError as error:
            _LOG.warning("%s: made, but not kept: %s", path, error.strerror or error)
