# SPDX-License-Identifier: Apache-2.0
"""Quantities computed from a recording: loads, precession, penetration of the wall, forces of the string."""
