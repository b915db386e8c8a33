# SPDX-License-Identifier: Apache-2.0
"""Measured beside computed, and of each number whether it is a fit or a prediction (docs/validation.md)."""

from drill_twin_evidence.validation import ufrj, well_b
from drill_twin_evidence.validation.comparison import Comparison, Validation, data_folder

RECORDS = {"ufrj_rig": ufrj.validate, "well_b": well_b.validate}
"""Comparison with each record, by the folder of its files."""

__all__ = ["RECORDS", "Comparison", "Validation", "data_folder"]
