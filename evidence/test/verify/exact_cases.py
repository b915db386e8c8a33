# SPDX-License-Identifier: Apache-2.0
"""Cases of `drill-twin study verify` as tests."""

from itertools import cycle

import pytest

from drill_twin_evidence.verify import Case, all_cases
from drill_twin_evidence.verify.case import FORMS, Function


def cases_of(*topics: str) -> pytest.MarkDecorator:
    """Run a test for every case of these topics: one variant of each check without a mark, the other ones long.

    The checks take turns in the form in which they run; those that are slow themselves are long in every variant.
    """
    chosen = [case for case in all_cases() if case.topic in topics]
    assert {case.topic for case in chosen} == set(topics)
    variants: dict[Function, list[Case]] = {}
    for case in chosen:
        variants.setdefault(case.function, []).append(case)
    turns = zip(variants.values(), cycle(FORMS), strict=False)
    first = {next((case for case in same if case.form == form), same[0]).name for same, form in turns}
    marks = {case.name: [pytest.mark.long] if case.long or case.name not in first else [] for case in chosen}
    return pytest.mark.parametrize(
        "case", [pytest.param(case, id=case.name, marks=marks[case.name]) for case in chosen]
    )


def check(case: Case) -> None:
    """Run it; every number must be within its tolerance."""
    rows = case.run()
    assert rows
    misses = [f"{row.what}: expected {row.expected:.8g}, computed {row.computed:.8g}, error {row.error:.1e}, "
              f"tolerance {row.tolerance:.0e}" for row in rows if not row.ok]  # fmt: skip
    assert not misses
