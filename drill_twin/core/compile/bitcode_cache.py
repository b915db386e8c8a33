# SPDX-License-Identifier: Apache-2.0
"""Compiled parts of kernels on disk: functions that only kernels call, shared by the kernels of all scenes.

Most functions of a kernel do not depend on the set of effects. Each is kept as bitcode, under a name that changes with
every source that its module reaches, with the types of its arguments, the versions and the processor; so a kernel of
another set types and lowers the loop around the effects only. Files are checked as those of kernels are
(`drill_twin.core.compile.object_cache`).
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
from drill_twin.core.compile.object_cache import CheckedFiles

_CACHING: Any = import_module("numba.core.caching")

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
