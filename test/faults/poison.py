# SPDX-License-Identifier: Apache-2.0
"""An effect that breaks the string on purpose, brought into the composition from outside: no scene can list it.

``python poison.py START END LONGEST PUSH NODE ...`` starts a node with it (`drill_twin.ros`).
"""

import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import kernel
from drill_twin.physics.model.mesh import Rod
from drill_twin.physics.model.strain import Point


@dataclass(frozen=True)
class Poison:
    """From a time to a time [s], in steps longer than a limit [s], a lateral force per length [N/m]; NaN is one too."""

    start: float
    end: float
    longest: float
    push: float
    requires: ClassVar[tuple[str, ...]] = ()
    provides: ClassVar[tuple[str, ...]] = ()
    disabled_for_static: ClassVar[tuple[str, ...]] = ()
    energy_class: ClassVar[str] = "any"
    variant: ClassVar[str] = ""

    def check_against(self, _: Any) -> tuple[()]:
        return ()


class Parameters(NamedTuple):
    start: float
    end: float
    longest: float
    push: float


def parameters(block: Poison, model: Any) -> Parameters:
    return Parameters(block.start, block.end, block.longest, block.push)


@kernel
def distributed_load(parameters: Any, rod: Rod, here: Point, half_step: float, load: Array, stiff: Array) -> None:
    dose = parameters.poison
    if dose.start <= here.time < dose.end and 2.0 * half_step > dose.longest and here.element == 2:
        load[0] += dose.push


def install(dose: Poison) -> None:
    """Have every scene of this process list it."""
    import drill_twin.physics.effects
    from drill_twin.scene.blocks.effects import Effects, EffectsBase

    name = "drill_twin.physics.effects.poison"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, Path(__file__))
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
        drill_twin.physics.effects.poison = module  # where the generated kernel imports it from
        drill_twin.physics.effects._FOUND["poison"] = module, module.Poison
    Effects.poison = dose
    if not hasattr(EffectsBase, "unpoisoned"):
        EffectsBase.unpoisoned = EffectsBase.names
        EffectsBase.names = property(lambda self: [*self.unpoisoned, "poison"])


def remove() -> None:
    """Have no scene list it any more."""
    from drill_twin.scene.blocks.effects import EffectsBase

    if hasattr(EffectsBase, "unpoisoned"):
        EffectsBase.names = EffectsBase.unpoisoned
        del EffectsBase.unpoisoned


@contextmanager
def poisoned(*dose: float) -> Iterator[None]:
    """Within this block."""
    install(Poison(*dose))
    try:
        yield
    finally:
        remove()


if __name__ == "__main__":
    install(Poison(*map(float, sys.argv[1:5])))
    from drill_twin.ros.entry_points import start

    sys.exit(start(sys.argv[5], sys.argv[6:]))
