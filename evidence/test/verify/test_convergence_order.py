# SPDX-License-Identifier: Apache-2.0
"""Orders of convergence, read off as slopes: four in space, two in time."""

from exact_cases import cases_of, check

from drill_twin_evidence.verify import Case


@cases_of("numerics.convergence_order")
def test_order(case: Case) -> None:
    check(case)
