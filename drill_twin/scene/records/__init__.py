# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers over time from files: CSV, MATLAB, LAS 2.0 and WITSML 1.4.1 time logs."""

from drill_twin.scene.records.columns import Columns
from drill_twin.scene.records.files import RECORDS, read_columns
from drill_twin.scene.records.mnemonics import CHANNELS

__all__ = ["CHANNELS", "RECORDS", "Columns", "read_columns"]
