# SPDX-License-Identifier: Apache-2.0
"""Catalogue: API drill pipe, heavy-weight drill pipe, casing, types of bit.

Drill pipe after API Spec 5DP and API RP 7G (new pipe): outer and inner diameter of the body. The adjusted weight with
tool joints and upsets depends on the joint, and is approximate. The make-up torque is of a usual connection of the
size, good enough for a plan.
"""

import math
import re
from operator import itemgetter
from typing import Any, NamedTuple

from drill_twin.core.errors import SceneError
from drill_twin.core.numerals import NUMBER
from drill_twin.core.units import parse
from drill_twin.core.units.dimension import LENGTH
from drill_twin.physics.effects.bit_torque_stribeck import BITS

INCH, POUND_PER_FOOT, FOOT_POUND = 0.0254, 1.48816394, 1.3558179
LARGEST_COLLAR = 7.0 * INCH
"""Outer diameter above which a collar is of the steel of large collars [m]."""
DENSITY = 7850.0
"""Density of steel, the default of a scene [kg/m^3]."""
ALUMINIUM = {"youngs_modulus": "69 GPa", "poisson_ratio": 0.33, "density": "2700 kg/m^3"}
MATERIALS: dict[str, dict[str, Any]] = {
    "STEEL": {}, "NONMAG": {}, "ALUMINIUM": ALUMINIUM, "ALUMINUM": ALUMINIUM, "AL": ALUMINIUM,
}  # fmt: skip
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
    nominal_mass: float
    """The name of drill pipe; of heavy-weight pipe the adjusted mass [kg/m]."""


def _pipe(outer: float, inner: float, weight: float, joint: float, torque: float, nominal: float = 0.0) -> Pipe:
    mass, nominal = weight * POUND_PER_FOOT, (nominal or weight) * POUND_PER_FOOT
    return Pipe(outer * INCH, inner * INCH, mass, joint * INCH, torque * FOOT_POUND, nominal)


PIPES = {
    "pipe": (
        _pipe(2.875, 2.151, 10.87, 4.125, 7_000.0, 10.40),
        _pipe(3.5, 2.764, 14.06, 4.75, 10_800.0, 13.30),
        _pipe(3.5, 2.602, 16.54, 5.0, 12_400.0, 15.50),
        _pipe(4.0, 3.340, 15.85, 5.25, 14_000.0, 14.00),
        _pipe(4.5, 3.826, 18.37, 6.25, 20_400.0, 16.60),
        _pipe(4.5, 3.640, 22.09, 6.25, 22_800.0, 20.00),
        _pipe(5.0, 4.276, 21.92, 6.625, 27_000.0, 19.50),
        _pipe(5.0, 4.000, 28.32, 6.625, 30_700.0, 25.60),
        _pipe(5.5, 4.778, 24.80, 7.0, 33_400.0, 21.90),
        _pipe(5.5, 4.670, 27.74, 7.0, 33_400.0, 24.70),
        _pipe(6.625, 5.965, 28.38, 8.0, 43_900.0, 25.20),
    ),
    "heavy": (  # with its joints and central upset, after makers' tables
        _pipe(3.5, 2.0625, 25.3, 4.75, 9_900.0),
        _pipe(4.0, 2.5625, 29.7, 5.25, 14_100.0),
        _pipe(4.5, 2.75, 41.0, 6.25, 21_800.0),
        _pipe(5.0, 3.0, 49.3, 6.625, 29_400.0),
        _pipe(5.5, 3.375, 57.0, 7.0, 33_200.0),
        _pipe(6.625, 4.5, 71.3, 8.0, 46_900.0),
    ),
}
_CASING = (
    "4 1/2", "5", "5 1/2", "6 5/8", "7", "7 5/8", "7 3/4", "8 5/8", "9 5/8", "10 3/4", "11 3/4", "13 3/8", "16",
    "18 5/8", "20",
)  # fmt: skip
"""Outer diameters of API 5CT casing [in]; no bore of such casing is an outer diameter within `SAME`."""
_BITS = {"bicentre": "bicentre bicenter", "hybrid": "hybrid", "pdc": "pdc", "roller_cone": "rollercone tricone"}
"""Words by type of bit, without spaces and hyphens; a hybrid and a bi-centre bit may be called PDC beside."""
_PLAN_BIT = re.compile(rf"(?ais)({NUMBER}(?:\s+\d+/\d+|/\d+)?\s*(?:(?:in|inch|mm|cm|m|ft)(?![a-z])|[\"'″”′’])?)?(.*)")
"""Diameter of a bit with its unit, and its type."""
ROCK = {"specific_energy": "170 MPa"}
"""Specific energy of the rock (25 ksi): a stand-in, to be replaced by a measured value."""
BIT_TORQUE = {"sliding": 0.4, "sticking": 0.5, "decay": "0.9 s/rad"}
"""Friction on rock of a bit of no type, at a third of its diameter: a stand-in, to be replaced by measured values."""
SAME, NEAR = 1e-3, 1e-2
"""Relative differences up to which a size and a weight of a tally count as one of the catalogue."""
ROUNDED = 0.05
"""Relative difference up to which weights of a tube are the same, rounded; with joints twice that."""


def area(outer: float, inner: float) -> float:
    """Cross-section of a tube [m^2] by its diameters [m]."""
    return 0.25 * math.pi * (outer**2 - inner**2)


def find_pipe(kind: str, outer: float, inner: float, mass: float) -> Pipe | None:
    """Pipe of the catalogue that has the numbers of a row; None if there is no such pipe, or more than one.

    Args:
        kind: `pipe` or `heavy`.
        outer: Outer diameter [m].
        inner: Bore [m]; NaN: not known.
        mass: Mass per length [kg/m], the nominal one or the one with joints, which is then kept; NaN: not known.
    """
    sizes, sure = [pipe for pipe in PIPES[kind] if same(pipe.outer_diameter, outer, SAME)], kind == "heavy"
    if not math.isnan(inner):
        tube, sure = area(outer, inner), True
        sizes = [pipe for pipe in sizes if same(area(pipe.outer_diameter, pipe.inner_diameter), tube, ROUNDED)]
    if math.isnan(mass):
        return sizes[0] if len(sizes) == 1 and sure else None
    share = 2.0 * ROUNDED if sure else NEAR
    fitting = [
        (abs(own - mass), pipe._replace(adjusted_mass=kept))
        for pipe in sizes
        for own, kept, near in ((pipe.adjusted_mass, mass, share), (pipe.nominal_mass, pipe.adjusted_mass, NEAR))
        if same(own, mass, near)
    ]
    return min(fitting, key=itemgetter(0), default=(0.0, None))[1]  # 24.8 lb/ft is no rounded 24.7 lb/ft


def casing_size(diameter: float) -> str:
    """Size of API 5CT casing with an outer diameter [m], as `9 5/8`; empty if no size has it."""
    return next((size for size in _CASING if same(parse(f"{size} in", LENGTH), diameter, SAME)), "")


def bit_type(text: str) -> str:
    """Type of bit in a text, as a scene has it (`roller_cone` for `8 1/2 in Roller-cone bit`); empty: none."""
    letters = re.sub("[^a-z]", "", text.lower())
    return next((kind for kind, named in _BITS.items() for word in named.split() if word in letters), "")


def plan_bit(text: str) -> tuple[str, str]:
    """Type of the bit of a plan, and the text of its diameter; each empty where the plan has none.

    Raises:
        SceneError: The words beside the diameter name no type.
    """
    size, words = _PLAN_BIT.findall(text.strip())[0]
    kind = bit_type(words)
    if re.search(r"\d", words) or not (kind or words.strip(" .,").lower() in {"", "bit"}):
        raise SceneError(
            f'--bit: expected diameter and type, {", ".join(BITS)}, as "8 1/2 in pdc", found "{text[:60]}"; leave '
            "another type out, and give its law in the scene"
        )
    return kind, size


def bit_law(kind: str) -> dict[str, Any]:
    """Torque law of a type of bit, or of a bit of no type, and rock, as a scene file has them."""
    return ({"bit": kind} if kind else BIT_TORQUE) | ROCK


def named_sizes(kind: str, outer: float) -> str:
    """The three pipes whose outer diameter [m] is nearest, as text for messages."""
    return ", ".join(
        f"{size / INCH:.4g} in {nominal / POUND_PER_FOOT:.4g} lb/ft (bore {inner / INCH:.4g}, with joints "
        f"{mass / POUND_PER_FOOT:.4g})"
        for size, inner, mass, _, _, nominal in sorted(PIPES[kind], key=lambda pipe: abs(pipe[0] - outer))[:3]
    )


def same(one: float, other: float, share: float) -> bool:
    """True for numbers that differ by at most a share of the first; False for NaN."""
    return abs(one - other) <= share * one
