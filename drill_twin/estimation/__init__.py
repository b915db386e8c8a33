# SPDX-License-Identifier: Apache-2.0
"""Estimates of state and numbers of a running rig from what is measured, by an ensemble that is corrected."""

from drill_twin.estimation.square_root_filter import Correction, correction

__all__ = ["Correction", "correction"]
