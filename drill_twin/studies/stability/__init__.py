# SPDX-License-Identifier: Apache-2.0
"""Which steps the scheme can take, measured, beside the steps that an explicit scheme could (docs/stability.md)."""

from drill_twin.studies.stability.bound import explicit_limit
from drill_twin.studies.stability.figure import draw
from drill_twin.studies.stability.measure import Cell, measure, stability_map

__all__ = ["Cell", "draw", "explicit_limit", "measure", "stability_map"]
