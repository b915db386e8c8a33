# SPDX-License-Identifier: Apache-2.0
"""Work arrays of the spatial formulation, allocated once: no kernel allocates."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.physics.model.section import RESULTANTS


class Workspace(NamedTuple):
    """The block system, and the small matrices of the current element and Gauss point."""

    lower: Array  # (n, 7, 8) block of node i + 1 by node i
    diagonal: Array  # (n + 1, 7, 8) last column the residual, then the Newton step
    upper: Array  # (n, 7, 8) block of node i by node i + 1
    spare: Array  # (7, 8)
    ends: Array  # (2, 7, 8) loads on bit and top: tangent, and residual in the last column
    reaction: Array  # (2, 7) residual at bit and top before the constraints were imposed: forces of rig and rock
    end_rows: Array  # (2, 7, 14) their rows of the system
    command: Array  # (3,) set-points: weight on bit [N], rotation [rad/s], speed of a block [m/s]
    resultants: Array  # (7,) see drill_twin.physics.model.section
    force: Array  # (8,) conjugate to r', r'', psi', psi
    saa: Array  # (3, 3) their derivatives
    sab: Array
    sba: Array
    sbb: Array
    coupling: Array  # (4, 3)
    load: Array  # (4,) force per length on r and couple per length on the spin
    stiff: Array  # (4, 4) minus its derivative by the velocities (and half_step times by the positions)
    ke: Array  # (9, 16) element tangent: component pair (x, y, z by x, y, z), then shape pair (4 by 4)
    kc: Array  # (4, 3, 4) spin coupling by component and shape: columns of node 0 and 1, rows of node 0 and 1
    re: Array  # (3, 4) element residual: component, shape
    ue: Array  # (4, 3) element unknowns: shape, component
    ve: Array  # (4, 3) velocities
    dv: Array  # (4, 3) velocity changes


def make_workspace(elements: int) -> Workspace:
    """Arrays of zeros for a string of so many elements."""
    n = elements
    return Workspace(
        lower=np.zeros((n, 7, 8)),
        diagonal=np.zeros((n + 1, 7, 8)),
        upper=np.zeros((n, 7, 8)),
        spare=np.zeros((7, 8)),
        ends=np.zeros((2, 7, 8)),
        reaction=np.zeros((2, 7)),
        end_rows=np.zeros((2, 7, 14)),
        command=np.zeros(3),
        resultants=np.zeros(RESULTANTS),
        force=np.zeros(8),
        saa=np.zeros((3, 3)),
        sab=np.zeros((3, 3)),
        sba=np.zeros((3, 3)),
        sbb=np.zeros((3, 3)),
        coupling=np.zeros((4, 3)),
        load=np.zeros(4),
        stiff=np.zeros((4, 4)),
        ke=np.zeros((9, 16)),
        kc=np.zeros((4, 3, 4)),
        re=np.zeros((3, 4)),
        ue=np.zeros((4, 3)),
        ve=np.zeros((4, 3)),
        dv=np.zeros((4, 3)),
    )
