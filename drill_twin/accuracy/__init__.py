# SPDX-License-Identifier: Apache-2.0
"""`accuracy: 1 %`: elements and step from a cost curve, what to expect, and what came of it (docs/accuracy.md)."""

from drill_twin.accuracy.check import Outcome, check
from drill_twin.accuracy.error_model import Point, Promise
from drill_twin.accuracy.plan import Plan, resolve

__all__ = ["Outcome", "Plan", "Point", "Promise", "check", "resolve"]
