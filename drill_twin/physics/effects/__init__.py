# SPDX-License-Identifier: Apache-2.0
"""Effects of a scene: one file each, with its block of the scene and its compiled functions.

A file is an effect if it defines an `EffectConfig` of its own name: `wall_friction.py` and `WallFriction`. Another
package adds effects through the entry-point group ``drill_twin.effects``: the entry's name is the key in a scene, its
value the module (``my_effect = my_package.my_effect``).
"""

import warnings
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

from drill_twin.core.companions import entries
from drill_twin.core.errors import RunError
from drill_twin.physics.effects.config import HOOKS, EffectConfig, uncalled

GROUP = "drill_twin.effects"
"""Entry-point group of effects in other packages."""
LEFT_OUT: dict[str, str] = {}
"""Key of an effect of another package that cannot be run -> why."""


def _config_of(key: str, module: ModuleType) -> type[EffectConfig] | None:
    config = getattr(module, "".join(word.capitalize() for word in key.split("_")), None)
    if isinstance(config, type) and issubclass(config, EffectConfig) and config is not EffectConfig:
        return config
    return None


def _find() -> dict[str, tuple[ModuleType, type[EffectConfig]]]:
    found = {}
    for file in iter_modules(__path__):
        module = import_module(f"{__name__}.{file.name}")
        if (config := _config_of(file.name, module)) is not None:
            found[file.name] = module, config
    for entry in sorted(entries(GROUP), key=lambda entry: entry.name):
        trouble = ""
        try:
            module = import_module(entry.value)
            config = _config_of(entry.name, module)
        except Exception as error:  # noqa: BLE001 - another package must not stop this one
            trouble = f"{type(error).__name__}: {error}"
        else:
            if entry.name in found:
                trouble = f"there is an effect of that name in {found[entry.name][0].__name__}"
            elif config is None:
                trouble = f"{entry.value} defines no EffectConfig of that name in CamelCase"
            elif not (trouble := uncalled(module, config)):
                found[entry.name] = module, config
        if trouble:
            LEFT_OUT[entry.name] = trouble
            warnings.warn(f"the effect {entry.name} of {entry.value} is left out: {trouble}", stacklevel=2)
    return found


_FOUND = _find()
EFFECTS: dict[str, type[EffectConfig]] = {key: config for key, (_, config) in _FOUND.items()}
"""Key in a scene file -> its config: those of this package by name, then those of other packages."""


def effect_module(effect: str) -> ModuleType:
    """The module of an effect, by its key in the scene, with or without a variant."""
    return _FOUND[key_of(effect)][0]


def effect_config(effect: str) -> type[EffectConfig]:
    """The class of an effect's block, by the same."""
    return _FOUND[key_of(effect)][1]


def parameters_of(effect: str, block: EffectConfig, model: Any) -> Any:
    """Parameters of an effect's functions, by its `parameters`; without one they are the fields of its block."""
    module = effect_module(effect)
    if hasattr(module, "parameters"):
        return module.parameters(block, model)
    return module.Parameters(*(getattr(block, name) for name in module.Parameters._fields))


def key_of(effect: str) -> str:
    """Key in the scene of an effect with a variant: `wall_friction` of `wall_friction:arctan`."""
    return effect.partition(":")[0]


def with_variant(key: str, config: EffectConfig) -> str:
    """Key of an effect in a kernel: that of the scene, with the variant that the block asks for.

    Raises:
        RunError: The module has no function of the variant.
    """
    variant = config.variant
    if variant and not any(hasattr(effect_module(key), f"{hook}_{variant}") for hook in HOOKS):
        functions = ", ".join(f"{hook}_{variant}" for hook in HOOKS)
        raise RunError(f'effects.{key}: expected one of the functions {functions} for the variant "{variant}" of its '
                       f"block, found none in {effect_module(key).__name__}")  # fmt: skip
    return f"{key}:{variant}" if variant else key


def function_name(effect: str, hook: str) -> str:
    """Name of an effect's compiled function in its module, for the variant if it has one of its own; "" if none."""
    module, (_, _, variant) = effect_module(effect), effect.partition(":")
    return next((name for name in (f"{hook}_{variant}", hook) if hasattr(module, name)), "")


__all__ = [
    "EFFECTS", "GROUP", "LEFT_OUT", "EffectConfig", "effect_module", "function_name", "key_of", "parameters_of",
    "with_variant",
]  # fmt: skip
