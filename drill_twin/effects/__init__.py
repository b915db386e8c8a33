# SPDX-License-Identifier: Apache-2.0
"""The effects a scene can call for: one file each, with its scene block and its compiled function.

A file is an effect if it defines a `Block` of its own name: `wall_friction.py` and `WallFriction`. Nothing else need
know of it.
"""

from importlib import import_module
from pkgutil import iter_modules

from drill_twin.effects.block import Block


def _blocks() -> dict[str, type[Block]]:
    found = {}
    for module in iter_modules(__path__):
        name = "".join(word.capitalize() for word in module.name.split("_"))
        block = getattr(import_module(f"{__name__}.{module.name}"), name, None)
        if isinstance(block, type) and issubclass(block, Block) and block is not Block:
            found[module.name] = block
    return found


BLOCKS: dict[str, type[Block]] = _blocks()
"""Key in a scene file -> block, in the order of the alphabet."""

__all__ = ["BLOCKS", "Block"]
