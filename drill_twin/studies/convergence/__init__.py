# SPDX-License-Identifier: Apache-2.0
"""Cost of accuracy: a scene over formulations, elements and time steps, against its converged run."""

from drill_twin.studies.accuracy.errors import MotionErrors
from drill_twin.studies.convergence.curve import (
    Curve,
    Resolution,
    choose_resolutions,
    measure,
    on_meshes,
    require_marks,
)

__all__ = ["Curve", "MotionErrors", "Resolution", "choose_resolutions", "measure", "on_meshes", "require_marks"]
