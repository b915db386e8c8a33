# SPDX-License-Identifier: Apache-2.0
"""Parameters of the rig from a scene: weight on bit, controller and inertia of the top drive."""

import numpy as np

from drill_twin.model.bit import make_bit
from drill_twin.scene import Scene
from drill_twin.solver.boundary.rig import Drive


def make_drive(scene: Scene, hanging: float) -> Drive:
    """Make the drive of a scene.

    Args:
        scene: The scene.
        hanging: Axial weight of the string [N].
    """
    top = scene.rig.top_drive
    from_top = scene.rig.weight_on_bit.at == "top"
    proportional, integral = top.gains(*_torsion_of_the_string(scene))
    return Drive(
        from_top=1.0 if from_top else 0.0,
        hanging=hanging,
        driven=0.0 if top.model == "prescribed" else 1.0,
        proportional=proportional,
        integral=integral,
        limit=np.inf if top.torque_limit is None else top.torque_limit,
        inertia=top.inertia,
        damping=top.damping,
        memory=np.zeros(4),
        bit=make_bit(scene.rig.first[0] + (hanging if from_top else 0.0)),
    )


def _torsion_of_the_string(scene: Scene) -> tuple[float, float]:
    """Impedance of the top section to torsional waves [N m s/rad], time of such a wave from top to bit [s]."""
    top = scene.string.sections[-1]
    impedance = 2.0 * top.second_moment * np.sqrt(top.shear_modulus * top.density)
    delay = sum(part.length * np.sqrt(part.density / part.shear_modulus) for part in scene.string.sections)
    return float(impedance), float(delay)
