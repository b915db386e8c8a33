# SPDX-License-Identifier: Apache-2.0
"""Results of runs: arrays, findings, figures, and the analysis of plain arrays."""
