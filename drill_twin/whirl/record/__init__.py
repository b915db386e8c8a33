# SPDX-License-Identifier: Apache-2.0
"""Whole records: spectrum, precession, statistics of a run."""
