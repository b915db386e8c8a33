# SPDX-License-Identifier: Apache-2.0
"""Base classes of a scene's parts and of the effects' blocks; names of the functions of an effect that a run calls."""

import difflib
from collections import namedtuple
from collections.abc import Iterable, Iterator, Sequence
from types import ModuleType
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails

from drill_twin.core.errors import shortened
from drill_twin.core.units import Length, Whole, Within, refuse, show

HOOKS = {
    "axial_damping": "parameters, element, axial, rate",
    "section_stress": "parameters, rod, strain, half_step, resultants",
    "distributed_load": "parameters, rod, here, half_step, load, stiff",
    "end_load": "parameters, rod, command, time, half_step, u, v, v_old, ends",
    "node_load": "parameters, rod, time, half_step, u, v, v_old, nodes",
    "prescribed_motion": "parameters, rod, time, trial",
    "after_step": "parameters, rod, command, time, step, u, v",
    "missed": "parameters, v",
}
"""Functions of an effect that the loop calls, and their arguments."""
_OTHERS = ("dissipated_power", "side_friction", "initial_state", "parameters", "Parameters")
NEAR = 0.85
"""Likeness (`difflib`) from which a name is a misspelling: a letter of `end_load` too many or too few has 0.93."""


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise refuse(f"expected true or false, found {show(value)}")
    return value


Seed = Annotated[int, Whole(0, 2**63 - 1)]
"""Seed of the random numbers of an effect; the same seed gives the same run."""
Flag = Annotated[bool, BeforeValidator(_flag)]
"""True or false."""
BitReaction = Literal["torque", "weight"]
EnergyClass = Literal["kept", "heat", "any"]


def parameters_class(config: type["EffectConfig"]) -> Any:
    """Class `Parameters` of an effect whose functions take the fields of its block as they are, all of them numbers."""
    return namedtuple("Parameters", config.model_fields, module=config.__module__)  # noqa: PYI024 - its fields vary


def _printable(text: str) -> str:
    if not text.isprintable():
        raise refuse(f"expected a name of printable characters on one line, found {shortened(text, 60)}")
    return text


Label = Annotated[str, Field(max_length=100), AfterValidator(_printable)]
"""Name for logs, titles and folders: no control character and no mark that reverses the text around it."""


Problem = tuple[tuple[str | int, ...], str]
"""Place inside the part that is checked, () for the whole part, and message: expected and found."""


class Part(BaseModel):
    """Frozen part of a scene; unknown keys are rejected, and values that contradict each other."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if found := list(self.problems()):
            raise refuse_all(found)
        return self

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between the values of this part, each of which is valid by itself."""
        yield from ()


def refuse_all(problems: Iterable[Problem]) -> ValidationError:
    """Make a validation error of several problems, each with its place inside the part being checked."""
    return ValidationError.from_exception_data(
        "scene", [InitErrorDetails(type=refuse(text), loc=place, input=None) for place, text in problems]
    )


def repeated_names(key: str, parts: Sequence[Any]) -> Iterator[Problem]:
    """Problems of parts under a key whose name an earlier part has."""
    names = [part.name for part in parts]
    for index, name in enumerate(names):
        if name in names[:index]:
            yield (key, index, "name"), f'expected a name of its own, found "{name}" again'


def out_of_order(intervals: Sequence[Any]) -> Iterator[Problem]:
    """Problems of `intervals`, each with its `top` and `bottom` [m], that are not from the top down, or overlap."""
    above = 0.0
    for index, interval in enumerate(intervals):
        if interval.top < above:
            text = f"expected at least {above:.6g} m, where the interval above ends, found {interval.top:.6g} m"
            yield ("intervals", index, "top"), text
        if interval.bottom <= interval.top:
            text = f"expected more than its top ({interval.top:.6g} m), found {interval.bottom:.6g} m"
            yield ("intervals", index, "bottom"), text
        above = interval.bottom


def too_large(
    place: tuple[str | int, ...], found: float, bound: float, name: str, *, below: bool = False
) -> Iterator[Problem]:
    """Yield a length [m] above a bound of the scene, or with `below` also a length at the bound.

    Args:
        place: Keys of the length in its block.
        found: The length.
        bound: The bound.
        name: Words for the bound, such as `radius of the hole`.
        below: True if the length must be less than the bound.
    """
    if found > bound or (below and found == bound):
        expected = "less than" if below else "at most"
        yield place, f"expected {expected} the {name} ({bound:.6g} m), found {found:.6g} m"


Depth = Annotated[Length, Within(at_least="0 m", at_most="20 km", reason="the longest wells reach 15 km")]


class DepthInterval(Part):
    """Interval of the hole."""

    top: Depth
    """Measured depth of its top, from the top clamp [m]."""
    bottom: Depth
    """Measured depth of its bottom [m]."""


class EffectConfig(Part):
    """The parameters of one effect, as `effects: <key>:` of a scene file."""

    requires: ClassVar[tuple[str, ...]] = ()
    """Keys of the effects that must be listed too."""
    provides: ClassVar[tuple[BitReaction, ...]] = ()
    """Reactions of the rock on the bit that it computes in full, so that a scene lists one such effect for each: the
    torque, and the axial force that supports a weight set at the top."""
    energy_class: ClassVar[EnergyClass] = "any"
    """Energy taken from the string: conservative (`kept`), all dissipated (`heat`), or neither (`any`)."""
    across: ClassVar[bool] = False
    """Acts across the string only: left out where the string follows the hole (`numerics.lateral_from`)."""
    disabled_for_static: ClassVar[tuple[str, ...]] = ()
    """Fields set to zero in the search for the static equilibrium: excitation and friction."""
    seed_is_of: ClassVar[str] = ""
    """Field of what its `seed` draws; without it a seed other than 1, the default, would change nothing: refused."""

    @model_validator(mode="after")
    def _seed_is_of_something_random(self) -> Self:
        random, seed = self.seed_is_of, getattr(self, "seed", 1)
        if random and seed != 1 and (random not in self.model_fields_set or getattr(self, random) is None):
            raise refuse(f"expected a `seed` with `{random}` only, found {seed} where nothing is random")
        return self

    @property
    def variant(self) -> str:
        """Suffix of the compiled functions this block calls for, where there are several; "" for the default functions.

        The choice is made when the kernel is generated, so that the other functions cost nothing.
        """
        return ""

    def check_against(self, scene: Any) -> Iterator[Problem]:  # noqa: ARG002, the subclasses use it
        """Yield the contradictions with the rest of the scene, whose parts are valid by themselves.

        Args:
            scene: The `drill_twin.scene.Scene` that lists the effect.
        """
        yield from ()


def misspelled(module: ModuleType, config: type[EffectConfig]) -> str:
    """Words for the first public function of an effect, or method of its block, whose name nearly is a called name.

    A function that nothing calls by name is a helper, and may have any name that is not nearly a called name.
    """
    functions = [name for name, value in vars(module).items() if callable(value)]
    methods = [name for name in vars(config) if name not in config.model_fields]
    for found, known in ((functions, (*HOOKS, *_OTHERS)), (methods, (*vars(Part), *vars(EffectConfig)))):
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
