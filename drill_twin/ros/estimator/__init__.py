# SPDX-License-Identifier: Apache-2.0
"""Node `estimator`: an ensemble beside a rig (docs/estimator.md)."""
