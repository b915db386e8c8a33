# SPDX-License-Identifier: Apache-2.0
"""Functions of an effect that nothing would call are named; helpers of any other name are not."""

from types import ModuleType
from typing import Any

import pytest

from drill_twin.physics.effects import EFFECTS, EffectConfig, effect_module
from drill_twin.physics.effects.config import HOOKS, misspelled, uncalled


class Block(EffectConfig):
    """A block without keys."""


class Odd(EffectConfig):
    """A block with a method that nothing calls."""

    def check_agianst(self, scene: Any) -> Any:
        """Yield nothing."""
        yield scene


def module_of(*names: str) -> ModuleType:
    """A module with functions of these names, and `Parameters` with a capital."""
    module = ModuleType("own_effect")
    for name in names:
        setattr(module, name, Block if name[0].isupper() else lambda: None)
    return module


@pytest.mark.parametrize(
    ("names", "near"),
    [
        ("distributed_loads Parameters", "distributed_load"), ("distribute_load Parameters", "distributed_load"),
        ("distributedload Parameters", "distributed_load"), ("distributed_laod Parameters", "distributed_load"),
        ("distributed_loads_soft Parameters", "distributed_load"), ("end_laod Parameters", "end_load"),
        ("endload Parameters", "end_load"), ("after_steps Parameters", "after_step"),
        ("section_stresses Parameters", "section_stress"), ("axial_dampning Parameters", "axial_damping"),
        ("prescribe_motion Parameters", "prescribed_motion"), ("initial_sate Parameters", "initial_state"),
        ("end_load Paramters", "Parameters"), ("end_load paramters Parameters", "parameters"),
        ("distributed_load disipated_power Parameters", "dissipated_power"),
    ],
)  # fmt: skip
def test_a_misspelled_function_is_told_with_the_nearest_name(names: str, near: str) -> None:
    words = uncalled(module_of(*names.split()), Block)
    assert f'which nothing calls, did you mean "{near}"?' in words


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("Parameters push", "expected one of the functions axial_damping, "),
        ("distributed_load", "expected `Parameters` beside distributed_load, found none"),
        ("Parameters parameters", "expected one of the functions axial_damping, "),
    ],
)
def test_an_effect_that_does_nothing_is_told(names: str, words: str) -> None:
    assert words in uncalled(module_of(*names.split()), Block)


def test_a_misspelled_method_of_a_block_is_told() -> None:
    assert 'found "check_agianst", which nothing calls, did you mean "check_against"?' in uncalled(
        module_of("end_load", "Parameters"), Odd
    )


@pytest.mark.parametrize(
    "name",
    [
        "_distributed_loads",
        "stiffness_of",
        "load_along",
        "force",
        "end_load_soft",
        "parameters_of",
        "friction",
        "stress",
    ],
)
def test_a_helper_may_have_any_other_name(name: str) -> None:
    assert uncalled(module_of(name, "end_load", "Parameters"), Block) == ""


@pytest.mark.parametrize("key", EFFECTS)
def test_every_function_of_our_own_effects_is_called_or_a_helper(key: str) -> None:
    assert misspelled(effect_module(key), EFFECTS[key]) == ""
    if key not in {"stretch", "torsion", "mud"}:  # switches, and properties that others read
        assert uncalled(effect_module(key), EFFECTS[key]) == ""


@pytest.mark.parametrize("hook", HOOKS)
def test_each_hook_alone_makes_an_effect(hook: str) -> None:
    assert uncalled(module_of(hook, "Parameters"), Block) == ""
