# SPDX-License-Identifier: Apache-2.0
"""What no state of a string can be, and a way back to the last good frame."""

from drill_twin.guard.bounds import bounds_of
from drill_twin.guard.guard import CALM, TRIES, Guard, most_cuts
from drill_twin.guard.violation import REMEDIES, Violation

__all__ = ["CALM", "REMEDIES", "TRIES", "Guard", "Violation", "bounds_of", "most_cuts"]
