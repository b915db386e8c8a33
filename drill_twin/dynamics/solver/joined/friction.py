# SPDX-License-Identifier: Apache-2.0
"""Friction on a string that follows the hole: the laws of `drill_twin.physics.effects.wall_friction`, without the wall.

They are written out once more: with a shared function LLVM orders the sums of the string in space differently, and the
last bits of every run change.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from drill_twin.core.compile.jit import kernel
from drill_twin.physics.effects.friction_dual import dual_variable
from drill_twin.physics.effects.wall_friction import Parameters, arctan_size, step_limit, step_size
from drill_twin.physics.model.strain import Point

Law = tuple[float, float, float, float, float, float]


def bind_law(
    *, arctan: bool = False, sliding: bool = False, stribeck: bool = False, step: bool = False
) -> tuple[Any, Any]:
    """The law of a variant and its fall over slip; the branches of the others leave no machine code."""

    @kernel
    def law_at(law: Parameters, slip: float) -> Law:
        """Size by which the slip is divided and size times slope, limit and its part above mu_d, two factors of it."""
        steep, falling = 0.0, 1.0 + law.decay * slip
        if step:
            size, bend = step_size(law, slip)
        elif arctan:
            size, bend = arctan_size(law, slip)
        else:
            size, bend = np.sqrt(slip * slip + law.creep * law.creep), 1.0
        if step:
            limit, excess = step_limit(law, slip)
        elif stribeck:
            steep = (law.decay * slip) ** law.exponent
            excess = (law.coefficient - law.sliding) * np.exp(-steep)
            limit = law.sliding + excess
        elif sliding:
            excess = (law.coefficient - law.sliding) / falling
            limit = law.sliding + excess
        else:
            excess = limit = law.coefficient / falling
        return size, bend, limit, excess, steep, falling

    @kernel
    def fall_over_slip(law: Parameters, excess: float, slip: float, steep: float, falling: float) -> float:
        """Decrease of the limit with slip, over slip; without a branch, negligible within the creep."""
        if step:
            return excess / max(slip, law.low)
        if stribeck:
            slower = max(slip, law.creep)
            return excess * law.exponent * steep / (slower * slower)
        return excess * law.decay / (falling * max(slip, law.creep))

    return law_at, fall_over_slip


def side_friction(variant: str) -> Callable[..., tuple[float, float, float, float, float, float]]:
    """Friction on a string that follows the hole, for a variant of the block."""
    law_at, fall_over_slip = bind_law(**dict.fromkeys(filter(None, variant.split("_")), True))

    @kernel
    def friction(
        law: Parameters, lever: float, here: Point, along: float, across: float
    ) -> tuple[float, float, float, float, float, float]:
        """Force of the wall, friction along the hole, couple, and minus their slopes: z by z, z by spin, spin by spin.

        The wall carries the load across the hole together with the friction around it, N^2 (1 + (mu s_t)^2) = W^2, as
        a pipe that turns climbs its wall.

        Args:
            law: Parameters of the block.
            lever: Contact radius [m].
            here: The point.
            along: Speed along the hole [m/s].
            across: Load across the hole W [N/m].
        """
        around = lever * here.spin_rate
        slip = np.sqrt(around * around + along * along)
        size, bend, limit, excess, steep, falling = law_at(law, slip)
        excess, limit = law.scale[here.place] * excess, law.scale[here.place] * limit
        st, sz = around / size, along / size
        force = across / np.sqrt(1.0 + (limit * st) ** 2)
        ft, fz = -limit * force * st, -limit * force * sz
        dt, dz = dual_variable(law.memory[here.place], here.first_iteration, here.iteration, around, along, size, bend)
        scale = limit * force / size
        fall = fall_over_slip(law, excess * force, slip, steep, falling)
        tt, zz = scale * (1.0 - bend * dt * st) - fall * st * around, scale * (1.0 - bend * dz * sz) - fall * sz * along
        mixed = -0.5 * bend * scale * (dt * sz + dz * st) - fall * st * along
        return force, fz, lever * ft, zz, lever * mixed, lever * lever * tt

    return friction
