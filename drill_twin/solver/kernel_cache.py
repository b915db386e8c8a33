# SPDX-License-Identifier: Apache-2.0
"""Cache of compiled kernels on disk, each under a name that changes with its machine code.

numba's own cache checks one file and does not see edits in the functions that it calls. So a small module is written
into the cache folder and named by a hash of every source that it reaches, of the versions and of the processor: an
edit gives another name, and stale code is never run.
"""

import hashlib
import importlib.util
import os
import platform
import sys
import tempfile
from pathlib import Path
from types import ModuleType

import llvmlite
import numba
import numpy as np

from drill_twin.errors import RunError
from drill_twin.solver.source_hash import source_hash


def cache_folder() -> Path:
    """Folder of compiled kernels: the permanent one, else a temporary one.

    Raises:
        RunError: The folder named by ``$DRILL_TWIN_CACHE`` cannot be made.
    """
    return permanent_folder() or Path(tempfile.mkdtemp(prefix="drill_twin_kernels_"))


def permanent_folder() -> Path | None:
    """Folder shared by all processes: ``$DRILL_TWIN_CACHE``, else the user's cache folder; None: it is read-only.

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
    return None


def load_generated(kind: str, text: str, *more: str, packages: tuple[str, ...] = ()) -> ModuleType:
    """Import a generated module, numba's cache of it included, under a name that changes with its machine code.

    Args:
        kind: First part of its name.
        text: Its source.
        more: Texts besides the sources on which the machine code depends, such as the types of arguments.
        packages: Packages besides this one whose source it uses.
    """
    return _load(f"drill_twin_{kind}_{fingerprint(text, *more, packages=packages)}", text)


def fingerprint(text: str, *more: str, packages: tuple[str, ...] = ()) -> str:
    """Hash of all source that a module reaches, of other texts, of the versions of libraries and of the processor."""
    digest = hashlib.sha256(source_hash(text, packages).encode())
    for part in (*more, platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(part.encode())
    cpu = llvmlite.binding
    digest.update(f"{cpu.get_host_cpu_name()} {sorted(cpu.get_host_cpu_features().items())}".encode())
    return digest.hexdigest()[:16]


def _load(name: str, text: str) -> ModuleType:
    """The module of this name in the cache folder, written there if it is not."""
    if name in sys.modules:
        return sys.modules[name]
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        # Several processes may start at once: write beside, then rename, so that none reads half a file.
        with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".part", delete=False) as part:
            part.write(text)
        Path(part.name).replace(path)
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"the generated kernel {path} cannot be loaded; remove the file and start again")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
