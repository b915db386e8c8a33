# SPDX-License-Identifier: Apache-2.0
"""The `effects:` part of a scene: one optional block per file in `drill_twin/physics/effects/`."""

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field, create_model

from drill_twin.physics.effects import EFFECTS, EffectConfig
from drill_twin.physics.effects.config import Part


class EffectsBase(Part):
    """Effects of a scene; an effect that is not listed is not computed."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """The block of an effect, or None where it is off."""

    @property
    def names(self) -> list[str]:
        """Keys of the effects that are on, in the order of the registry."""
        return [key for key in EFFECTS if getattr(self, key) is not None]

    @property
    def blocks(self) -> dict[str, EffectConfig]:
        """Blocks of the effects that are on, by key."""
        return {key: getattr(self, key) for key in self.names}

    def providing(self, what: str) -> list[str]:
        """Keys of the effects that are on and compute the rock's reaction on the bit, `torque` or `weight`."""
        return [key for key, block in self.blocks.items() if what in block.provides]


def _on_or_off(value: Any) -> Any:
    """Block of a key without a value or with `on` (the defaults), None for `off`."""
    if value is None or value is True:
        return {}
    return None if value is False else value


def _field(block: type[EffectConfig]) -> tuple[Any, Any]:
    about = (block.__doc__ or "").strip()
    return Annotated[block | None, BeforeValidator(_on_or_off)], Field(default=None, description=about)


if TYPE_CHECKING:

    class Effects(EffectsBase):
        """Effects of a scene, one optional block per key of the registry."""
else:
    Effects = create_model(
        "Effects", __base__=EffectsBase, __module__=__name__, __doc__=EffectsBase.__doc__,
        **{key: _field(block) for key, block in EFFECTS.items()},
    )  # fmt: skip
