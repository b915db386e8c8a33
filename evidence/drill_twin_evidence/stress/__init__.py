# SPDX-License-Identifier: Apache-2.0
"""Stress study: runs of the scenes in `config/hard/`, for `drill-twin study hard` and evidence/docs/hard.md."""

from drill_twin_evidence.stress.case import HardCase, all_hard_cases, choose_hard
from drill_twin_evidence.stress.run import Result, run_case, run_hard

__all__ = ["HardCase", "Result", "all_hard_cases", "choose_hard", "run_case", "run_hard"]
