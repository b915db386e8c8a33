# SPDX-License-Identifier: Apache-2.0
"""Catalogue of pipe: API drill pipe, heavy-weight drill pipe, grades.

Drill pipe after API Spec 5DP and API RP 7G (new pipe): outer and inner diameter of the body. The adjusted weight with
tool joints and upsets depends on the joint, and is approximate. The make-up torque is of a usual connection of the
size, good enough for a plan.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from drill_twin.core.units import parse
from drill_twin.core.units.dimension import LENGTH

INCH, POUND_PER_FOOT, FOOT_POUND = 0.0254, 1.48816394, 1.3558179
LARGEST_COLLAR = 7.0 * INCH
"""Outer diameter above which a collar is of the steel of large collars [m]."""
DENSITY = 7850.0
"""Density of steel, the default of a scene [kg/m^3]."""
ALUMINIUM = {"youngs_modulus": "69 GPa", "poisson_ratio": 0.33, "density": "2700 kg/m^3"}
MATERIALS: dict[str, dict[str, Any]] = {"": {}, "steel": {}, "aluminium": ALUMINIUM, "aluminum": ALUMINIUM}
"""Keys of a section by material; steel is the default of a scene."""


class Pipe(NamedTuple):
    """Pipe of the catalogue, SI."""

    outer_diameter: float
    inner_diameter: float
    adjusted_mass: float
    """With tool joints and upsets [kg/m]."""
    joint_diameter: float
    """Outer diameter of the tool joints [m]."""
    make_up_torque: float
    """[N m]."""


def _pipe(outer: float, inner: float, weight: float, joint: float, torque: float) -> Pipe:
    return Pipe(outer * INCH, inner * INCH, weight * POUND_PER_FOOT, joint * INCH, torque * FOOT_POUND)


DRILL_PIPE = {  # (outer diameter [in], nominal weight [lb/ft])
    (2.875, 10.40): _pipe(2.875, 2.151, 10.87, 4.125, 7_000.0),
    (3.5, 13.30): _pipe(3.5, 2.764, 14.06, 4.75, 10_800.0),
    (3.5, 15.50): _pipe(3.5, 2.602, 16.54, 5.0, 12_400.0),
    (4.0, 14.00): _pipe(4.0, 3.340, 15.85, 5.25, 14_000.0),
    (4.5, 16.60): _pipe(4.5, 3.826, 18.37, 6.25, 20_400.0),
    (4.5, 20.00): _pipe(4.5, 3.640, 22.09, 6.25, 22_800.0),
    (5.0, 19.50): _pipe(5.0, 4.276, 21.92, 6.625, 27_000.0),
    (5.0, 25.60): _pipe(5.0, 4.000, 28.32, 6.625, 30_700.0),
    (5.5, 21.90): _pipe(5.5, 4.778, 24.80, 7.0, 33_400.0),
    (5.5, 24.70): _pipe(5.5, 4.670, 27.74, 7.0, 33_400.0),
    (6.625, 25.20): _pipe(6.625, 5.965, 28.38, 8.0, 43_900.0),
}
HEAVY_WEIGHT = {  # outer diameter [in]
    3.5: _pipe(3.5, 2.0625, 25.3, 4.75, 9_900.0),
    4.0: _pipe(4.0, 2.5625, 29.7, 5.25, 14_100.0),
    4.5: _pipe(4.5, 2.75, 41.0, 6.25, 21_800.0),
    5.0: _pipe(5.0, 3.0, 49.3, 6.625, 29_400.0),
    5.5: _pipe(5.5, 3.375, 57.0, 7.0, 33_200.0),
    6.625: _pipe(6.625, 4.5, 71.3, 8.0, 46_900.0),
}
"""Heavy-weight drill pipe with its joints and central upset, after makers' tables."""
_CASING = (
    "4 1/2", "5", "5 1/2", "6 5/8", "7", "7 5/8", "7 3/4", "8 5/8", "9 5/8", "10 3/4", "11 3/4", "13 3/8", "16",
    "18 5/8", "20",
)  # fmt: skip
"""Outer diameters of API 5CT casing [in]; no bore of such casing is an outer diameter within `SAME`."""
SAME = 1e-3
"""Relative difference up to which a size of a tally counts as a size of the catalogue."""


def drill_pipe(outer_diameter: float, mass: float) -> Pipe | None:
    """Drill pipe of an outer diameter [m] and a nominal mass per length [kg/m]; None if there is no such pipe."""
    for (outer, weight), pipe in DRILL_PIPE.items():
        if _same(outer * INCH, outer_diameter, SAME) and _same(weight * POUND_PER_FOOT, mass, 10.0 * SAME):
            return pipe
    return None


def heavy_weight(outer_diameter: float) -> Pipe | None:
    """Heavy-weight drill pipe of an outer diameter [m]; None if there is no such pipe."""
    return next((pipe for size, pipe in HEAVY_WEIGHT.items() if _same(size * INCH, outer_diameter, SAME)), None)


def casing_size(diameter: float) -> str:
    """Size of API 5CT casing with an outer diameter [m], as `9 5/8`; empty if no size has it."""
    sizes = (size for size in _CASING if _same(parse(f"{size} in", LENGTH), diameter, SAME))
    return next(sizes, "")


def named_sizes() -> str:
    """Drill pipe as text, for messages."""
    return ", ".join(f"{outer:g} in {weight:g} lb/ft" for outer, weight in DRILL_PIPE)


def _same(one: float, other: float, share: float) -> bool:
    return abs(one - other) <= share * one
