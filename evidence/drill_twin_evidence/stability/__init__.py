# SPDX-License-Identifier: Apache-2.0
"""Stability study: time steps that the scheme can take, beside the limit of an explicit scheme (docs/stability.md)."""

from drill_twin_evidence.stability.bound import explicit_limit
from drill_twin_evidence.stability.figure import draw
from drill_twin_evidence.stability.measure import Cell, measure, stability_map

__all__ = ["Cell", "draw", "explicit_limit", "measure", "stability_map"]
