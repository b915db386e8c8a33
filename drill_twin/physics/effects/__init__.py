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
from typing import Any, NamedTuple, Self

from drill_twin.core.companions import entries
from drill_twin.core.errors import RunError
from drill_twin.physics.effects import discs, supports
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
"""Key in a scene file -> its config: effects of this package by name, then effects of other packages."""
PARTS: dict[str, ModuleType] = {"discs": discs, "supports": supports}
"""Key in `string:` -> module of parts of the string whose functions a kernel calls as it calls an effect's."""


class Effect(NamedTuple):
    """An effect as a kernel calls it."""

    key: str
    """Its key in the scene."""
    variant: str = ""
    """Suffix of the functions that serve one variant of the block only, here the scene's variant; "" for none."""

    @classmethod
    def of(cls, key: str, block: EffectConfig) -> Self:
        """The effect with the variant that its block asks for.

        Raises:
            RunError: The module has no function of the variant.
        """
        effect, module = cls(key, block.variant), effect_module(key)
        if effect.variant and not any(hasattr(module, f"{hook}_{effect.variant}") for hook in HOOKS):
            functions = ", ".join(f"{hook}_{effect.variant}" for hook in HOOKS)
            raise RunError(f'effects.{key}: expected one of the functions {functions} for the variant '
                           f'"{effect.variant}" of its block, found none in {module.__name__}')  # fmt: skip
        return effect

    @property
    def config(self) -> type[EffectConfig]:
        """Class of its block."""
        return EffectConfig if self.key in PARTS else _FOUND[self.key][1]

    def function(self, hook: str) -> str:
        """Name of its function for a hook, the variant's function where there is one; "" for no function."""
        names = (f"{hook}_{self.variant}", hook)
        return next((name for name in names if hasattr(effect_module(self.key), name)), "")

    def __str__(self) -> str:
        """Key and variant, such as `wall_friction:arctan`."""
        return f"{self.key}:{self.variant}" if self.variant else self.key


def effect_module(key: str) -> ModuleType:
    """The module of an effect, or of a part of the string, by its key in the scene."""
    return PARTS[key] if key in PARTS else _FOUND[key][0]


def parameters_of(key: str, block: Any, model: Any) -> Any:
    """Parameters of an effect's functions, by its `parameters`; without one they are the fields of its block."""
    module = effect_module(key)
    if hasattr(module, "parameters"):
        return module.parameters(block, model)
    return module.Parameters(*(getattr(block, name) for name in module.Parameters._fields))


__all__ = ["EFFECTS", "GROUP", "LEFT_OUT", "PARTS", "Effect", "EffectConfig", "effect_module", "parameters_of"]
