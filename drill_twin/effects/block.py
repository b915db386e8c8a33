# SPDX-License-Identifier: Apache-2.0
"""What every effect's block in a scene file has in common."""

from typing import ClassVar

from pydantic import BaseModel, ConfigDict


class Block(BaseModel):
    """The parameters of one effect, as `effects: <key>:` of a scene file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    needs: ClassVar[tuple[str, ...]] = ()
    """Keys of the effects that must be listed too."""
