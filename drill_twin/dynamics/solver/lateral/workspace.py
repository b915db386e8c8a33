# SPDX-License-Identifier: Apache-2.0
"""Work arrays of the lateral formulation, allocated once: no kernel allocates."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.model.section import RESULTANTS

# Indices into Workspace.axial: force at the bit and at the top [N], load on the string along the axis [N], torque of
# the top drive [N m].
AT_BIT, AT_TOP, WEIGHT, TORQUE = 0, 1, 2, 3


class Workspace(NamedTuple):
    """The block system, and the small matrices of the current element."""

    lower: Array  # (n, 4, 4)
    diagonal: Array  # (n + 1, 4, 4)
    upper: Array  # (n, 4, 4)
    inverse: Array  # (n + 1, 4, 4) of the pivot blocks; with it, lower and upper are factors
    right: Array  # (n + 1, 4)
    reuse: Array  # (5,) see drill_twin.dynamics.solver.lateral.tangent_reuse
    ends: Array  # (2, 7, 8) loads on bit and top, as in space
    command: Array  # (3,) set-points: weight on bit [N], rotation [rad/s], speed of a block [m/s]
    lever: Array  # (n + 1, 4) change of the torque below by the unknowns' velocities
    axial: Array  # (4,) see AT_BIT
    resultants: Array  # (7,) see drill_twin.physics.model.section
    load: Array  # (4,)
    stiff: Array  # (4, 4)
    ke: Array  # (4, 16) element tangent: component pair xx, xy, yx, yy, then shape pair
    re: Array  # (2, 4) element residual: component, shape
    ue: Array  # (2, 4) element unknowns: component, shape
    ve: Array  # (2, 4) velocities
    dv: Array  # (2, 4) velocity changes


def make_workspace(elements: int) -> Workspace:
    """Arrays of zeros for a string of so many elements."""
    n = elements
    return Workspace(
        lower=np.zeros((n, 4, 4)),
        diagonal=np.zeros((n + 1, 4, 4)),
        upper=np.zeros((n, 4, 4)),
        inverse=np.zeros((n + 1, 4, 4)),
        right=np.zeros((n + 1, 4)),
        reuse=np.zeros(5),
        ends=np.zeros((2, 7, 8)),
        command=np.zeros(3),
        lever=np.zeros((n + 1, 4)),
        axial=np.zeros(4),
        resultants=np.zeros(RESULTANTS),
        load=np.zeros(4),
        stiff=np.zeros((4, 4)),
        ke=np.zeros((4, 16)),
        re=np.zeros((2, 4)),
        ue=np.zeros((2, 4)),
        ve=np.zeros((2, 4)),
        dv=np.zeros((2, 4)),
    )
