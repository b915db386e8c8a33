# SPDX-License-Identifier: Apache-2.0
"""Time of each effect in a Newton iteration: its functions alone, measured over the Gauss points of a string.

In the time loop the effects are one piece of machine code, and a clock inside would cost more than they do. So each
effect's functions are compiled once more, each in a loop of its own, and timed at the current state (contact with the
wall takes longer than none). Alone they run a little slower than in the time loop, where the compiler merges common
expressions; the figures tell which effect is expensive.
"""

import time
from copy import deepcopy
from typing import Any

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.effects import effect_module
from drill_twin.model.mesh import Rod
from drill_twin.model.section import RESULTANTS
from drill_twin.solver.kernel_cache import load_generated
from drill_twin.solver.kernel_codegen import packages_of

_TIMED = ("distributed_load", "section_stress", "end_load")
_POINTS, _TRIES = 2000, 3  # Gauss points of one measurement, measurements of which the shortest counts

_HEAD = '''"""Each effect in a loop of its own. Written by drill_twin; do not edit."""
from drill_twin.base.jit import entry_kernel
from drill_twin.model.point import Point
from drill_twin.model.strain import Strain
'''
_POINT = """
{import_line}


@entry_kernel
def {name}_distributed_load(rounds, parameters, rod, p, h2, load, stiff):
    for k in range(rounds):
        for g in range(p.shape[0]):
            here = Point(
                g // 2, g, 0.0, p[g, 0], p[g, 1], p[g, 2], p[g, 3], p[g, 4], p[g, 5], 0.0, 0.0, 0.0, p[g, 6], p[g, 7],
                p[g, 8], p[g, 9], p[g, 10], 0.0, p[g, 11], p[g, 12], k == 0, float(k),
            )
            of_{name}.distributed_load(parameters, rod, here, h2, load, stiff)
"""
_SECTION = """
{import_line}


@entry_kernel
def {name}_section_stress(rounds, parameters, rod, p, h2, resultants):
    for k in range(rounds):
        for g in range(p.shape[0]):
            strain = Strain(
                g // 2, g, 1.0, p[g, 6], p[g, 7], p[g, 8], 0.0, p[g, 0], p[g, 1], 0.0, p[g, 3], p[g, 4], 0.0, 2.0, 0.0,
                0.0, p[g, 10], 0.0, 0.0, 0.0, p[g, 9], p[g, 11], p[g, 12],
            )
            of_{name}.section_stress(parameters, rod, strain, h2, resultants)
"""
_END = """
{import_line}


@entry_kernel
def {name}_end_load(rounds, parameters, rod, command, h2, u, v, ends):
    for k in range(rounds):
        of_{name}.end_load(parameters, rod, command, 0.0, h2, u, v, v, ends)
"""


class EffectTimer:
    """Times the effects of one kernel.

    Attributes:
        effects: Those that act at every iteration, and so are timed.
    """

    def __init__(self, effects: tuple[str, ...], parameters: Any, rod: Rod) -> None:
        """Compile the loops, or load them from the kernel cache.

        Args:
            effects: As for `build_kernel`.
            parameters: Of the kernel; copied, since some effects have memory there.
            rod: The string, n elements.
        """
        templates = list(zip(_TIMED, (_POINT, _SECTION, _END), strict=True))
        parts = [
            text.format(name=name, import_line=_import_line(name))
            for hook, text in templates
            for name in effects
            if _has(name, hook)
        ]
        self.effects = tuple(name for name in effects if any(_has(name, hook) for hook in _TIMED))
        text = _HEAD + "".join(parts)
        self._module = load_generated("effect_timing", text, type(parameters).__module__, packages=packages_of(effects))
        self._parameters, self._rod = deepcopy(parameters), rod
        self._load, self._stiff, self._resultants = np.zeros(4), np.zeros((4, 4)), np.zeros(RESULTANTS)
        self._ends = np.zeros((2, 7, 8))

    def price(self, effect: str, u: Array, v: Array, command: Array, h2: float) -> float:
        """Time that an effect takes in one Newton iteration [s].

        Args:
            effect: One of `effects`.
            u: Node rows, shape (n + 1, 7).
            v: Their velocities, shape (n + 1, 7).
            command: Set-points, shape (2,).
            h2: Half a step [s].
        """
        seen = _at_gauss_points(self._rod, u, v)
        rounds = max(_POINTS // seen.shape[0], 10)
        arguments = {
            "distributed_load": (seen, h2, self._load, self._stiff),
            "section_stress": (seen, h2, self._resultants),
            "end_load": (command, h2, u, v, self._ends),
        }
        return sum(
            _price(getattr(self._module, f"{effect}_{hook}"), rounds, (self._parameters, self._rod, *arguments[hook]))
            for hook in _TIMED
            if _has(effect, hook)
        )


def _import_line(effect: str) -> str:
    package, _, module = effect_module(effect).__name__.rpartition(".")
    return f"from {package} import {module} as of_{effect}" if package else f"import {module} as of_{effect}"


def _has(effect: str, hook: str) -> bool:
    return hasattr(effect_module(effect), hook)


def _price(loop: Any, rounds: int, arguments: tuple[Any, ...]) -> float:
    """Time of one round [s]: the shortest of a few measurements, as other load on the machine only adds to it."""

    def quickest(count: int) -> float:
        times = []
        for _ in range(_TRIES):
            begun = time.perf_counter()
            loop(count, *arguments)
            times.append(time.perf_counter() - begun)
        return min(times)

    return max(quickest(rounds) - quickest(0), 0.0) / rounds


def _at_gauss_points(rod: Rod, u: Array, v: Array) -> Array:
    """Position, velocity, tangent, spin, spin rate, cosine and sine of the spin, shape (2 n, 13)."""
    shape = rod.shape[:, :, :2, :]  # (n, 2, 2, 4): value and slope, on (r, r') of both ends
    ends = [np.stack((w[:-1, 0:3], w[:-1, 3:6], w[1:, 0:3], w[1:, 3:6]), axis=1) for w in (u, v)]
    (place, slope), (speed, _) = (np.moveaxis(np.einsum("egdi,eic->egdc", shape, end), 2, 0) for end in ends)
    tangent = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
    spin, rate = (
        w[:-1, None, 6] * rod.spin_shape[None, :, 0] + w[1:, None, 6] * rod.spin_shape[None, :, 1] for w in (u, v)
    )
    columns = (
        place,
        speed,
        tangent,
        spin[..., None],
        rate[..., None],
        np.cos(spin)[..., None],
        np.sin(spin)[..., None],
    )
    return np.ascontiguousarray(np.concatenate(columns, axis=-1).reshape(-1, 13))
