# SPDX-License-Identifier: Apache-2.0
"""What every effect's block in a scene file has in common."""

from typing import Annotated, Any, ClassVar

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


class Block(BaseModel):
    """The parameters of one effect, as `effects: <key>:` of a scene file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    needs: ClassVar[tuple[str, ...]] = ()
    """Keys of the effects that must be listed too."""
