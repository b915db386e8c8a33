# SPDX-License-Identifier: Apache-2.0
"""Estimates of state and numbers of a running rig from what is measured, by an ensemble that is corrected."""

from drill_twin_studies.estimation.ensemble_filter import CHANNELS, EnsembleFilter, EstimatorOptions
from drill_twin_studies.estimation.estimate import Estimate
from drill_twin_studies.estimation.intake import SET_POINTS, Intake
from drill_twin_studies.estimation.members import LOAD

__all__ = [
    "CHANNELS",
    "LOAD",
    "SET_POINTS",
    "EnsembleFilter",
    "Estimate",
    "EstimatorOptions",
    "Intake",
]
