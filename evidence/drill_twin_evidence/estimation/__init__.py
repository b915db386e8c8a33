# SPDX-License-Identifier: Apache-2.0
"""Score of the estimator on twins with hidden numbers."""
