# SPDX-License-Identifier: Apache-2.0
"""Verification: scenes whose results are compared with closed forms or published numbers.

The command `drill-twin study verify`, evidence/docs/verification.md and the tests in evidence/test/verify use the same
cases.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from importlib import import_module

from drill_twin_evidence.verify.case import CASES, Case
from drill_twin_evidence.verify.row import Row

TOPICS = {
    "dynamics.lateral_frequencies": "quiet",
    "statics.buckling": "quiet",
    "statics.lateral_buckling": "walled",
    "statics.statics": "quiet",
    "statics.bending": "bent",
    "dynamics.waves": "quiet",
    "dynamics.torsion": "two masses",
    "dynamics.damping": "quiet",
    "dynamics.mud": "quiet",
    "dynamics.rotor": "quiet",
    "dynamics.modes": "walled",
    "contact.contact": "walled",
    "statics.curved_hole": "walled, in a curved hole",
    "statics.block": "block",
    "statics.torque_drag": "walled, in a curved hole",
    "contact.whirl_states": "walled",
    "contact.rub": "walled",
    "contact.bit": "bit",
    "contact.fatigue": "walled, with fatigue",
    "contact.stick_slip": "two masses",
    "contact.regenerative": "regenerative",
    "numerics.conservation": "quiet",
    "numerics.symmetry": "walled",
    "numerics.convergence_order": "quiet",
    "numerics.formulations": "walled",
    "numerics.default_resolution": "quiet",
}
"""Modules with cases, in the order of the page, and the set of effects of nearly all of their scenes.

Cases with the same set run the same kernel.
"""


def all_cases() -> list[Case]:
    """Every case, in the order of the page."""
    for topic in TOPICS:
        import_module(f"drill_twin_evidence.verify.{topic}")
    order = list(TOPICS)
    return sorted(CASES, key=lambda case: order.index(case.topic))


def choose(pattern: str = "", *, quick: bool = False) -> list[Case]:
    """Cases whose name contains the pattern, or matches it if it contains `*` or `?`.

    Args:
        pattern: Part of a name or a pattern; empty: all cases.
        quick: Leave out the long cases.
    """
    wild = any(sign in pattern for sign in "*?")
    return [
        case
        for case in all_cases()
        if (fnmatchcase(case.name, pattern) if wild else pattern in case.name) and not (quick and case.long)
    ]


__all__ = ["TOPICS", "Case", "Row", "all_cases", "choose"]
