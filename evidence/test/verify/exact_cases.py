# SPDX-License-Identifier: Apache-2.0
"""Cases of `drill-twin verify` as tests."""

import pytest

from drill_twin_evidence.verify import Case, all_cases


def cases_of(*topics: str) -> pytest.MarkDecorator:
    """Run a test for every case of these topics; the long ones are for `make test-long`."""
    chosen = [case for case in all_cases() if case.topic in topics]
    assert {case.topic for case in chosen} == set(topics)
    marks = {True: [pytest.mark.long], False: []}
    cases = [pytest.param(case, id=case.name, marks=marks[case.long]) for case in chosen]
    return pytest.mark.parametrize("case", cases)


def check(case: Case) -> None:
    """Run it; every number must be within its tolerance."""
    rows = case.run()
    assert rows
    misses = [f"{row.what}: expected {row.expected:.8g}, computed {row.computed:.8g}, error {row.error:.1e}, "
              f"tolerance {row.tolerance:.0e}" for row in rows if not row.ok]  # fmt: skip
    assert not misses
