# SPDX-License-Identifier: Apache-2.0
"""Names of the functions of an effect that a run calls, and words for a module whose functions it would not call."""

import difflib
from collections.abc import Iterable
from types import ModuleType

from drill_twin.physics.effects.config import EffectConfig

HOOKS = {
    "axial_damping": "parameters, element, axial, rate",
    "section_stress": "parameters, rod, strain, half_step, resultants",
    "distributed_load": "parameters, rod, here, half_step, load, stiff",
    "end_load": "parameters, rod, command, time, half_step, u, v, v_old, ends",
    "prescribed_motion": "parameters, rod, time, trial",
    "after_step": "parameters, rod, command, time, step, u, v",
}
"""Functions of an effect that the loop calls, and their arguments."""
_OTHERS = ("dissipated_power", "initial_state", "parameters", "Parameters")
NEAR = 0.85
"""Likeness (`difflib`) from which a name is a misspelling: a letter of `end_load` too many or too few has 0.93."""


def misspelled(module: ModuleType, config: type[EffectConfig]) -> str:
    """Words for the first public function of an effect, or method of its block, that misses the name of one called.

    A name that nothing calls is that of a helper, which may have any other name.
    """
    functions = [name for name, value in vars(module).items() if callable(value)]
    methods = [name for name in vars(config) if name not in config.model_fields]
    for found, known in ((functions, (*HOOKS, *_OTHERS)), (methods, tuple(vars(EffectConfig)))):
        for name in found:
            if near := _nearly(name, [word for word in known if not word.startswith("_")]):
                return (
                    f'found "{name}", which nothing calls, did you mean "{near}"? A helper of such a name needs an '
                    "underscore before it"
                )
    return ""


def _nearly(name: str, known: Iterable[str]) -> str:
    """The known name, or its begin before a variant, that a public name misses by a letter or two; "" where none."""
    if name.startswith("_") or any(name == word or name.startswith(f"{word}_") for word in known):
        return ""
    likeness = {word: difflib.SequenceMatcher(None, name[: len(word) + 1], word).ratio() for word in known}
    near = max(likeness, key=likeness.__getitem__)
    return near if likeness[near] >= NEAR else ""


def uncalled(module: ModuleType, config: type[EffectConfig]) -> str:
    """Words for an effect of another package that a run would not call, or not in full; "" where it is in order."""
    called = [hook for hook in (*HOOKS, "initial_state") if hasattr(module, hook)]
    if words := misspelled(module, config):
        return words
    if not called:
        return f"expected one of the functions {', '.join((*HOOKS, 'initial_state'))}, found none"
    if called != ["initial_state"] and not hasattr(module, "Parameters"):
        return f"expected `Parameters` beside {called[0]}, found none"
    return ""
