# SPDX-License-Identifier: Apache-2.0
"""Boundary conditions at the ends of the string: rig, and frame of the hole at the bit."""
