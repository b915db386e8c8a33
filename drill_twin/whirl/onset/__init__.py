# SPDX-License-Identifier: Apache-2.0
"""Onset of whirl: detection and time of the threshold crossing."""
