# SPDX-License-Identifier: Apache-2.0
"""What accuracy costs in time: a scene over forms, elements and steps, against a converged run of itself."""

from drill_twin.study.cost.curve import Curve, Rung, ladder, measure
from drill_twin.study.cost.errors import Errors

__all__ = ["Curve", "Errors", "Rung", "ladder", "measure"]
