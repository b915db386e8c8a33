# SPDX-License-Identifier: Apache-2.0
"""Checks on a run: energy ledger, plausibility of a state, diagnosis of a failure, timing of each effect."""
