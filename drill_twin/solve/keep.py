# SPDX-License-Identifier: Apache-2.0
"""Compiled code kept on disk under a name made of all that decides it.

numba's own cache watches one file and does not see edits in the functions that it calls. So a small module is written
into the cache folder and named by a hash of every source it is built from, of the versions and of the processor: an
edit makes another name, and stale code cannot be met.
"""

import hashlib
import importlib.util
import inspect
import os
import platform
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from types import ModuleType

import llvmlite
import numba
import numpy as np

from drill_twin.errors import RunError


def cache_folder() -> Path:
    """Where compiled kernels are kept: ``$DRILL_TWIN_CACHE``, else the user's cache folder, else a temporary one.

    Raises:
        RunError: The named folder cannot be made.
    """
    named = os.environ.get("DRILL_TWIN_CACHE")
    base = Path(named) if named else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "drill_twin"
    try:
        base.mkdir(parents=True, exist_ok=True)
        if os.access(base, os.W_OK):
            return base
    except OSError as error:
        if named:
            raise RunError(
                f"DRILL_TWIN_CACHE: expected a folder that can be written to, found {named}: {error.strerror}; "
                "name another, or unset it"
            ) from error
    return Path(tempfile.mkdtemp(prefix="drill_twin_kernels_"))


def fingerprint(sources: tuple[str, ...], *more: str) -> str:
    """Hash of the sources of modules of this package (`rod.hole`), of other texts, of versions and processor."""
    digest = hashlib.sha256()
    for name in sources:
        digest.update(name.encode() + inspect.getsource(import_module(f"drill_twin.{name}")).encode())
    for text in (*more, platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(text.encode())
    cpu = llvmlite.binding
    digest.update(f"{cpu.get_host_cpu_name()} {sorted(cpu.get_host_cpu_features().items())}".encode())
    return digest.hexdigest()[:16]


def kept(name: str, text: str) -> ModuleType:
    """The module of this name in the cache folder, written there if it is not."""
    if name in sys.modules:
        return sys.modules[name]
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        # Several nodes may start at once: write beside, then rename, so that nobody reads half a file.
        with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".part", delete=False) as part:
            part.write(text)
        Path(part.name).replace(path)
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"the composed kernel {path} cannot be loaded; remove the file and start again")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
