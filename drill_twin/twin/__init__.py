# SPDX-License-Identifier: Apache-2.0
"""A scene that moves: the machine computes, the guard judges, the observer tells.

>>> twin = Twin(load_scene("pa6_bench"))
>>> frame = twin.step(Command(weight_on_bit=40.0, rotation=12.6), seconds=0.01)
"""

from drill_twin.twin.machine import LATERAL, SPATIAL, form_of
from drill_twin.twin.twin import Twin

__all__ = ["LATERAL", "SPATIAL", "Twin", "form_of"]
