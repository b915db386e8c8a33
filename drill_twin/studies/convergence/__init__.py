# SPDX-License-Identifier: Apache-2.0
"""What accuracy costs in time: a scene over forms, elements and steps, against a converged run of itself."""

from drill_twin.accuracy.errors import Errors
from drill_twin.studies.convergence.curve import Curve, Rung, ladder, measure

__all__ = ["Curve", "Errors", "Rung", "ladder", "measure"]
