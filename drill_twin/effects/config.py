# SPDX-License-Identifier: Apache-2.0
"""What every effect's block in a scene file has in common."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from drill_twin.units import refuse, show

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
"""Seed of what an effect draws at random: the same seed, the same run."""
Flag = Annotated[bool, BeforeValidator(_flag)]
"""True or false."""
Whole = Literal["torque", "weight"]
EnergyClass = Literal["kept", "heat", "any"]


class Incompatibility(NamedTuple):
    """What in a block contradicts the rest of its scene."""

    place: tuple[str | int, ...]
    """Keys that lead to it; () for the whole block."""
    text: str
    """What was expected and what was found."""


class EffectConfig(BaseModel):
    """The parameters of one effect, as `effects: <key>:` of a scene file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    requires: ClassVar[tuple[str, ...]] = ()
    """Keys of the effects that must be listed too."""
    provides: ClassVar[tuple[Whole, ...]] = ()
    """What it gives the whole of, so that a scene lists one such effect: the torque of the rock on the bit, and the
    force with which the rock carries a weight set at the top."""
    energy_class: ClassVar[EnergyClass] = "any"
    """What becomes of the energy it takes from the string: all can be had back, all is heat, or neither."""
    disabled_for_static: ClassVar[tuple[str, ...]] = ()
    """Fields that are set to nothing while the balance at rest is sought: of effects that move or hold the string."""

    def check_against(self, scene: Any) -> Iterator[Incompatibility]:  # noqa: ARG002, the blocks of effects use it
        """What contradicts the rest of the scene; each part of it has been checked by itself.

        Args:
            scene: The `drill_twin.scene.Scene` that lists the effect.
        """
        yield from ()
