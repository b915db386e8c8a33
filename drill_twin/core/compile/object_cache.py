# SPDX-License-Identifier: Apache-2.0
"""Machine code on disk, in files of this user alone.

numba's own cache fails for ever on a damaged index, and runs what another user has put there.

Most functions of a kernel do not depend on the set of effects. Each is kept as bitcode, under a name that changes with
every source that its module reaches, with the types of its arguments, the versions and the processor; so a kernel of
another set types and lowers the loop around the effects only.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from numba import types
from numba.core.dispatcher import Dispatcher

from drill_twin.core.compile.inlined_compiler import inlined_parts, lasting_name, restore_inlined, type_text
from drill_twin.core.compile.jit import is_inlined
from drill_twin.core.files.kept_files import CheckedFiles

_CACHING: Any = import_module("numba.core.caching")


def keep_machine_code(dispatcher: Any, before_compilation: Callable[[], None], *, allocates: bool) -> None:
    """Let a function of numba keep its machine code beside its source file.

    Args:
        dispatcher: The function.
        before_compilation: Called before it is compiled.
        allocates: Whether a function that it calls may allocate, if itself does not.
    """
    allocates |= dispatcher.targetoptions["_nrt"]
    dispatcher._cache = _Cache(dispatcher.py_func, before_compilation, allocates)  # noqa: SLF001  as `enable_caching`


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


def _files(folder: Path, base: str, suffix: str) -> CheckedFiles:
    return CheckedFiles(folder, base, suffix, dumps=_CACHING.dumps)


class _Cache(_CACHING.FunctionCache):  # type: ignore[misc]
    _impl_class = _Implementation

    def __init__(self, function: Any, before_compilation: Callable[[], None], allocates: bool) -> None:
        super().__init__(function)
        self._load = super().load_overload if allocates else self._load_overload
        self._cache_file = _files(Path(self._cache_path), self._impl.filename_base, "machine_code")
        self._before_compilation = before_compilation

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature; None where it has to be compiled.

        numba's own first tells its compiler all that it can compile, which takes 0.2 s. Code from a file needs only
        numba's memory of that, and only where it allocates.
        """
        found = self._load(sig, target_context)
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
        return _files(self._folder, base, "bitcode")


def _is_shared(argument_types: Any) -> bool:
    """Check that types mean the same in every process: no class of a generated module, no function as an argument."""
    classes = [one.instance_class for one in argument_types if hasattr(one, "instance_class")]
    modules = [sys.modules.get(found.__module__) for found in classes]
    generated = any(module is None or module.__spec__ is None for module in modules)
    return not generated and not any(isinstance(one, types.Callable) for one in argument_types)
