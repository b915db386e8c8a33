# SPDX-License-Identifier: Apache-2.0
"""The exact checks: buckling, frequencies, statics, waves, and what the two forms of the string have in common."""

from exact_cases import cases_of, check

from drill_twin_evidence.verify import TOPICS, Case

ELSEWHERE = {"numerics.conservation", "numerics.symmetry", "numerics.convergence_order"}  # files of their own


@cases_of(*(topic for topic in TOPICS if topic not in ELSEWHERE))
def test_exact(case: Case) -> None:
    check(case)
