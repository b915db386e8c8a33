# SPDX-License-Identifier: Apache-2.0
"""Studies of many runs or of records: operating maps with their advice, fits of numbers, and the estimator."""
