# SPDX-License-Identifier: Apache-2.0
"""docs/effects.md lists every effect, every option of it, and tests that exist."""

import re
from pathlib import Path

import pytest

from drill_twin.physics.effects import EFFECTS

HERE = Path(__file__).parent
PAGE = HERE.parents[2] / "docs" / "effects.md"
CASES = {
    f"{file.stem}.{name}"
    for file in (HERE.parents[2] / "evidence" / "drill_twin_evidence" / "verify").rglob("*.py")
    for name in re.findall(r"^@case\(.*\n(?:.*\n)*?def (\w+)", file.read_text("utf-8"), re.MULTILINE)
}
"""Exact checks of `drill-twin study verify`, by the text of their files: the package knows nothing of its evidence."""
ROWS = {
    cells[0].strip("` "): cells
    for line in PAGE.read_text().splitlines()
    if line.startswith("| `") and len(cells := re.split(r"(?<!\\)\|", line.strip("|"))) == 5
}


def test_the_page_lists_the_effects_and_no_others():
    assert ROWS.keys() == EFFECTS.keys()


@pytest.mark.parametrize("key", EFFECTS)
def test_each_row_tells_options_and_tests(key):
    _, options, formula, _, verified = ROWS[key]
    assert re.findall(r"`(\w+)`", options) == list(EFFECTS[key].model_fields), "options as the block has them"
    assert formula.strip()
    tests = re.findall(r"`([\w/]+\.py)`", verified)
    cases = {name for name in re.findall(r"`(\w+\.\w+)`", verified) if not name.endswith(".py")}
    assert tests or cases, "verified by nothing"
    assert cases <= CASES
    for name in tests:
        assert ((HERE.parents[2] if name.startswith("test/") else HERE) / name).is_file(), f"{name} is not there"
