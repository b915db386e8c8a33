# SPDX-License-Identifier: Apache-2.0
"""Resolution for a requested accuracy, from a cost curve, and check of the finished run (docs/accuracy.md)."""

from drill_twin.studies.accuracy.error_model import ErrorModel, MeasuredPoint
from drill_twin.studies.accuracy.plan import AccuracyPlan, AccuracyResult, check, resolve

__all__ = ["AccuracyPlan", "AccuracyResult", "ErrorModel", "MeasuredPoint", "check", "resolve"]
