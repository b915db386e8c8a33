# SPDX-License-Identifier: Apache-2.0
"""The scenes of the exact checks, for the tests beside them."""

from drill_twin.studies.verify.scenes import (
    BARE,
    DENSITY,
    DIAMETER,
    EA,
    EI,
    GJ,
    LENGTH,
    LINE_MASS,
    POISSON,
    ROLLING,
    YOUNG,
    rod_scene,
)

AREA = LINE_MASS / DENSITY

__all__ = [
    "AREA", "BARE", "DENSITY", "DIAMETER", "EA", "EI", "GJ", "LENGTH", "LINE_MASS", "POISSON", "ROLLING", "YOUNG",
    "rod_scene",
]  # fmt: skip
