# SPDX-License-Identifier: Apache-2.0
"""Orbits: radius and precession, runout separation, dominant precession."""
