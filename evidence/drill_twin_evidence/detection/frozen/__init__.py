# SPDX-License-Identifier: Apache-2.0
"""Frozen records that separate detectors of whirl, and the score of a detector on them.

The records are drawn from seeds on which nothing was tuned; they import nothing of `drill_twin.whirl` but the marks'
type. What is true of a record, and which numbers that needs, is said in `truth`.
"""

from drill_twin_evidence.detection.frozen.records import BASE, KINDS, frozen_records
from drill_twin_evidence.detection.frozen.score import Finding, FrozenScore, by_analyzer, score_of
from drill_twin_evidence.detection.frozen.truth import FrozenRecord, Truth, digest

__all__ = [
    "BASE", "KINDS", "Finding", "FrozenRecord", "FrozenScore", "Truth", "by_analyzer", "digest", "frozen_records",
    "score_of",
]  # fmt: skip
