# SPDX-License-Identifier: Apache-2.0
"""Resolution for a requested accuracy, from a cost curve, and check of the finished run (docs/accuracy.md)."""

from drill_twin.studies.accuracy.check import AccuracyResult, check
from drill_twin.studies.accuracy.error_model import ErrorModel, Point
from drill_twin.studies.accuracy.plan import Plan, resolve

__all__ = ["AccuracyResult", "ErrorModel", "Plan", "Point", "check", "resolve"]
