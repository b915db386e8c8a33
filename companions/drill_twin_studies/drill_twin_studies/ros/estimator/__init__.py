# SPDX-License-Identifier: Apache-2.0
"""Node `estimator`: an ensemble beside a rig (docs/drill_twin_studies/estimator.md)."""
