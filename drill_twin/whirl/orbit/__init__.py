# SPDX-License-Identifier: Apache-2.0
"""Orbits of the marks: radius, precession, runout separation, shape of the string."""
