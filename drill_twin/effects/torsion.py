# SPDX-License-Identifier: Apache-2.0
"""Torsional dynamics: the string twists and torsional waves run along it."""

from drill_twin.effects.config import EffectConfig


class Torsion(EffectConfig):
    """Spin of each node as unknowns of the twin, with stiffness G J."""

    energy_class = "kept"
