# SPDX-License-Identifier: Apache-2.0
"""Buckling loads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from drill_twin.scene import Scene
from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import EI, KICK, LENGTH, LINE_MASS, quiet_scene
from drill_twin_evidence.verify.signals import free_motion, squared_frequencies
from drill_twin_evidence.verify.statics.airy import critical_bit_load

# Effective length factors of Euler's column; clamped-pinned from tan x = x.
EULER = {"guided": 0.5, "pinned": np.pi / 4.493409458, "sliding": 1.0, "free": 2.0}
WEIGHT = LINE_MASS * 9.81


def buckling_load(scene_at: Callable[[float], Scene], exact: float, half: float, seconds: float) -> float:
    """Load at which the lowest omega^2 is zero: linear interpolation between `exact - half` and `exact + half`.

    Raises:
        ValueError: omega^2 does not change its sign between the two.
    """

    def lowest(load: float) -> float:
        return float(squared_frequencies(free_motion(scene_at(load), seconds, 0.04), 0.04, modes=5)[0])

    below, above = lowest(exact - half), lowest(exact + half)
    if not below > 0.0 > above:
        raise ValueError(
            f"expected omega^2 to fall through zero from {exact - half:.6g} to {exact + half:.6g}, "
            f"found {below:.6g} and {above:.6g} 1/s2"
        )
    return exact + half * (below + above) / (below - above)


@case(forms=FORMS, bit_end=tuple(EULER))
def euler(bit_end: str, form: str) -> Iterator[Row]:
    """Weightless column: the lowest omega^2 passes zero at Euler's load, with oscillation below it and growth above.

    Linear interpolation between 99 % and 101 % of the load; errors of interpolation, mesh and step of 2 ms: 1e-5 each.
    """

    def scene(load: float) -> Scene:
        return quiet_scene(KICK, bit_end=bit_end, weight_on_bit=load, step=2e-3, form=form)

    exact = float(np.pi**2 * EI / (EULER[bit_end] * LENGTH) ** 2)
    yield Row(
        what="buckling load [N]",
        reference="F = pi^2 EI / (K L)^2, K = 0.5, 0.6992, 1, 2",
        source="Euler 1757; Timoshenko and Gere 1961, ch. 2",
        expected=exact,
        computed=buckling_load(scene, exact, 0.01 * exact, 6.0),
        tolerance=1e-4,
    )


@case(forms=FORMS)
def self_weight(form: str) -> Iterator[Row]:
    """Buckling under its own weight of a column that stands on its clamp; the hole points up (inclination 180 deg).

    Evaluated as Euler's load.
    """

    def scene(weight: float) -> Scene:
        effects: dict[str, Any] = KICK | {"gravity": {"magnitude": weight / LINE_MASS}}
        return quiet_scene(effects, bit_end="free", inclination=np.pi, step=2e-3, form=form)

    exact = 7.83734744 * EI / LENGTH**3
    found = buckling_load(scene, exact, 0.01 * exact, 4.0)
    yield Row(
        what="critical w L^3 / EI [-]",
        reference="w L^3 / EI = 9/4 j^2, J_-1/3(j) = 0",
        source="Greenhill 1881",
        expected=7.83734744,
        computed=found * LENGTH**3 / EI,
        tolerance=1e-3,
    )


@case(forms=FORMS, bit_end=tuple(EULER), at=("bit", "top"))
def heavy_string(bit_end: str, at: str, form: str) -> Iterator[Row]:
    """Buckling load of the hanging rod with its weight; the load is given at the bit, or at the top and so less by the
    weight.

    Roots of the Airy-function determinant of EI y''' + (F - w s) y' = c, for each bit end. Linear interpolation between
    0.1 N below and above; the slowest modes, those of the free bit, show little more than a growth in the 6 s.
    """

    def scene(load: float) -> Scene:
        effects: dict[str, Any] = KICK | {"gravity": {"magnitude": 9.81}}
        return quiet_scene(effects, bit_end=bit_end, weight_on_bit=load, at=at, step=2e-3, form=form)

    exact = critical_bit_load(EI, WEIGHT, LENGTH, bit_end) - (WEIGHT * LENGTH if at == "top" else 0.0)
    yield Row(
        what="buckling load, counted there [N]",
        reference="EI y''' + (F - w s) y' = c; as many combinations of Ai, Bi and an integral of them as ends hold",
        source="Lubinski 1950",
        expected=exact,
        computed=buckling_load(scene, exact, 0.1, 6.0),
        tolerance=5e-3,
        relative=False,
    )
