# SPDX-License-Identifier: Apache-2.0
"""Axial dynamics: the string stretches and axial waves run along it."""

from drill_twin.effects.config import EffectConfig


class Stretch(EffectConfig):
    """Axial motion as unknowns of the twin, with stiffness E A."""

    energy_class = "kept"
