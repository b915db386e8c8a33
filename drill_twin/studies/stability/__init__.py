# SPDX-License-Identifier: Apache-2.0
"""Stability study: time steps that the scheme can take, beside the limit of an explicit scheme (docs/stability.md)."""

from drill_twin.studies.stability.bound import explicit_limit
from drill_twin.studies.stability.figure import draw
from drill_twin.studies.stability.measure import Cell, measure, stability_map

__all__ = ["Cell", "draw", "explicit_limit", "measure", "stability_map"]
