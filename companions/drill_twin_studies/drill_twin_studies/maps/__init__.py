# SPDX-License-Identifier: Apache-2.0
"""Operating map: regimes of motion over weight on bit and speed, from an ensemble that refines their boundaries."""

from drill_twin_studies.maps.operating_map import OperatingMap, read_map
from drill_twin_studies.maps.plane import Plane, Span
from drill_twin_studies.maps.regimes import Regime

__all__ = ["OperatingMap", "Plane", "Regime", "Span", "read_map"]
