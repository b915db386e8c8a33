# SPDX-License-Identifier: Apache-2.0
"""Steady whirls beside runs in time, on a grid of set-points."""
