# SPDX-License-Identifier: Apache-2.0
"""Quantities read of a section whose stress is counted (`drill_twin.physics.effects.fatigue`)."""

SCALARS = ("moment_x", "moment_y", "axial_force", "stress", "largest_stress", "cycles", "damage")
"""Bending moments that curve the string towards x and y of the turning material [N m], axial force [N], largest normal
stress at the surface now and so far [Pa], stress cycles and damage of the fibre with the most damage."""
MOMENT_X, MOMENT_Y, AXIAL_FORCE, STRESS, LARGEST_STRESS, CYCLES, DAMAGE = range(len(SCALARS))
