# SPDX-License-Identifier: Apache-2.0
"""Torsional dynamics: twist and torsional waves."""

from drill_twin.physics.effects.config import EffectConfig


class Torsion(EffectConfig):
    """Spin of the nodes as unknowns, with stiffness G J."""

    energy_class = "kept"
