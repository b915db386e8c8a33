# SPDX-License-Identifier: Apache-2.0
"""Base class of the effects' blocks in a scene file."""

from collections import namedtuple
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from drill_twin.core.units import refuse, show

LARGEST_SEED = 2**63 - 1


def _seed(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= LARGEST_SEED:
        raise refuse(f"expected a whole number from 0 to {LARGEST_SEED}, found {show(value)}")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise refuse(f"expected true or false, found {show(value)}")
    return value


Seed = Annotated[int, BeforeValidator(_seed), Field(ge=0, le=LARGEST_SEED)]
"""Seed of the random numbers of an effect; the same seed gives the same run."""
Flag = Annotated[bool, BeforeValidator(_flag)]
"""True or false."""
BitReaction = Literal["torque", "weight"]
EnergyClass = Literal["kept", "heat", "any"]


def parameters_class(config: type["EffectConfig"]) -> Any:
    """Class `Parameters` of an effect whose functions take the fields of its block as they are, all of them numbers."""
    return namedtuple("Parameters", config.model_fields, module=config.__module__)  # noqa: PYI024 - its fields vary


class Incompatibility(NamedTuple):
    """A contradiction between a block and the rest of its scene."""

    place: tuple[str | int, ...]
    """Keys of its place in the block; () for the whole block."""
    text: str
    """Message: expected and found."""


class EffectConfig(BaseModel):
    """The parameters of one effect, as `effects: <key>:` of a scene file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

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

    def refuse_seed(self, where: str, *, used: bool) -> None:
        """Refuse a `seed` that would change nothing; `where` says in words where one is used."""
        seed = getattr(self, "seed", 1)
        if not used and seed != type(self).model_fields["seed"].default:
            raise refuse(f"expected a `seed` {where} only, found {seed} where nothing is random")

    @property
    def variant(self) -> str:
        """Suffix of the compiled functions this block calls for, where there are several; "" for the default ones.

        The choice is made when the kernel is generated, so that the others cost nothing.
        """
        return ""

    def check_against(self, scene: Any) -> Iterator[Incompatibility]:  # noqa: ARG002, the subclasses use it
        """Yield the contradictions with the rest of the scene, whose parts are valid by themselves.

        Args:
            scene: The `drill_twin.scene.Scene` that lists the effect.
        """
        yield from ()
