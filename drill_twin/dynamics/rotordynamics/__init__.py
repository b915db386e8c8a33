# SPDX-License-Identifier: Apache-2.0
"""Modes, critical speeds and steady whirl of a string without simulation in time."""
