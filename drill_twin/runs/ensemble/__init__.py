# SPDX-License-Identifier: Apache-2.0
"""Ensembles: many runs of one scene with other numbers, each in compiled code on a thread of its own."""

from drill_twin.runs.ensemble.members import Member, expand
from drill_twin.runs.ensemble.outputs import OUTPUTS
from drill_twin.runs.ensemble.result import EnsembleResult
from drill_twin.runs.ensemble.run import Executor, Threads

__all__ = ["OUTPUTS", "EnsembleResult", "Executor", "Member", "Threads", "expand"]
