# SPDX-License-Identifier: Apache-2.0
"""Axial dynamics: stretch and axial waves."""

from drill_twin.physics.effects.config import EffectConfig


class Stretch(EffectConfig):
    """Axial motion of the nodes as unknowns, with stiffness E A."""

    energy_class = "kept"
