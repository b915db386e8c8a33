# SPDX-License-Identifier: Apache-2.0
"""Orders of convergence, read off as slopes: four in space, two in time."""

from holding import cases_of, check

from drill_twin.study.verify import Case


@cases_of("order")
def test_order(case: Case) -> None:
    check(case)
