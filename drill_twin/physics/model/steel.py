# SPDX-License-Identifier: Apache-2.0
"""Steel of drillstrings: grades with yield and tensile strength, and S-N curves."""

from typing import NamedTuple

KSI, MPA = 6.894757e6, 1e6


class Steel(NamedTuple):
    """Strength of a steel [Pa]."""

    yield_strength: float
    tensile_strength: float


GRADES = {
    "E75": Steel(75.0 * KSI, 100.0 * KSI),
    "X95": Steel(95.0 * KSI, 105.0 * KSI),
    "G105": Steel(105.0 * KSI, 115.0 * KSI),
    "S135": Steel(135.0 * KSI, 145.0 * KSI),
}
"""Grades of drill pipe (API Spec 5DP; the numbers as a maker of pipe prints them from Spec 5D, 1991)."""
DEFAULT_GRADE = "E75"
COLLAR, LARGE_COLLAR = Steel(110.0 * KSI, 140.0 * KSI), Steel(100.0 * KSI, 135.0 * KSI)
"""Collars up to 6 7/8 in., and larger ones (API Spec 7-1)."""
HEAVY_WEIGHT = Steel(55.0 * KSI, 95.0 * KSI)
"""Tube of heavy-weight drill pipe."""
_KNOWN = (*GRADES.values(), COLLAR, LARGE_COLLAR, HEAVY_WEIGHT)
_SAME = 5e-3  # relative difference of two yield strengths of the same steel


def steel_of(yield_strength: float | None) -> Steel:
    """Steel with a yield strength [Pa]: a known steel, else a steel whose tensile strength is its yield strength.

    Args:
        yield_strength: Where None, the yield strength of `DEFAULT_GRADE`.
    """
    if yield_strength is None:
        return GRADES[DEFAULT_GRADE]
    close = (steel for steel in _KNOWN if abs(steel.yield_strength - yield_strength) <= _SAME * yield_strength)
    return next(close, Steel(yield_strength, yield_strength))


DNV_AIR = {
    "b1": (15.117, 4.0), "b2": (14.885, 4.0), "c": (12.592, 3.0), "c1": (12.449, 3.0), "c2": (12.301, 3.0),
    "d": (12.164, 3.0), "e": (12.010, 3.0), "f": (11.855, 3.0), "f1": (11.699, 3.0), "f3": (11.546, 3.0),
    "g": (11.398, 3.0), "w1": (11.261, 3.0), "w2": (11.107, 3.0), "w3": (10.970, 3.0),
}  # fmt: skip
"""DNVGL-RP-C203, April 2016, table 2-1 (air): log10 of the cycles at a range of 1 MPa, and the slope;
5 beyond 1e7 cycles."""
KNEE, SLOPE_BEYOND = 1e7, 5.0
HIGH_STRENGTH = (17.446, 4.70)
"""DNVGL-RP-C203, 2.4.10: base metal of a yield strength above 500 MPa; its limit of 235 MPa holds in air only, and is
not used."""
API_RANGE, API_CYCLES = 40.0 * KSI, 1e6
"""API RP 7G (Lubinski 1961): bending of 20 000 psi to and fro without tension is endured; from memory, not checked."""
API_SLOPE = 4.593
"""From there to 0.9 of the tensile strength of E75 at 1000 cycles, the usual estimate (Shigley, Mischke and Budynas
2004): 3 / log10(0.9 * 100 ksi / 20 ksi)."""


def _straight(intercept: float, slope: float, beyond: float) -> tuple[float, float, float, float]:
    return MPA * 10.0 ** ((intercept - 7.0) / slope), KNEE, slope, beyond


CURVES = {
    "dnv_high_strength": _straight(*HIGH_STRENGTH, HIGH_STRENGTH[1]),
    "api_rp_7g": (API_RANGE, API_CYCLES, API_SLOPE, 0.0),
    **{f"dnv_{name}": _straight(*numbers, SLOPE_BEYOND) for name, numbers in DNV_AIR.items()},
}
"""Curves by name: stress range [Pa] and cycles at the knee, slope above it, and below it (0: no damage)."""
