# SPDX-License-Identifier: Apache-2.0
"""The library of hard scenes (`config/hard/`), run to the end and judged: for `drill-twin hard` and docs/hard.md."""

from drill_twin.study.hard.case import HardCase, all_hard_cases, choose_hard
from drill_twin.study.hard.judge import Result, run_case
from drill_twin.study.hard.run import run_hard

__all__ = ["HardCase", "Result", "all_hard_cases", "choose_hard", "run_case", "run_hard"]
