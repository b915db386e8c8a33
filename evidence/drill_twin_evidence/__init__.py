# SPDX-License-Identifier: Apache-2.0
"""Evidence that drill_twin is right: exact checks, records of rigs, the paper, stress, scores, benchmarks.

A distribution of its own, which drill_twin never imports; its commands come to `drill-twin` by entry points.
"""

from pathlib import Path

CONFIG = Path(__file__).parent / "config"
"""Folder of the hard scenes and of the paper's numbers."""
HARD = CONFIG / "hard"
"""Folder of the scenes `hard/NAME`."""
