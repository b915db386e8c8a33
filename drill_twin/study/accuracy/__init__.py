# SPDX-License-Identifier: Apache-2.0
"""`accuracy: 1 %`: elements and step from a cost curve, what to expect, and what came of it (docs/accuracy.md)."""

from drill_twin.study.accuracy.check import Outcome, check
from drill_twin.study.accuracy.plan import Plan, resolve
from drill_twin.study.cost.promise import Point, Promise

__all__ = ["Outcome", "Plan", "Point", "Promise", "check", "resolve"]
