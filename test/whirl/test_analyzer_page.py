# SPDX-License-Identifier: Apache-2.0
"""docs/analyzer.md names every state with the numbers that the code has; the measured figures are with the evidence."""

import re
from pathlib import Path

import pytest

from drill_twin.whirl import BitMotion, MotionState, criteria

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "analyzer.md").read_text("utf-8")
ROWS = {line.split("|")[1].strip(): line for line in reversed(PAGE.splitlines()) if line.startswith("| ")}


@pytest.mark.parametrize("state", MotionState, ids=lambda state: state.value)
def test_every_state_has_its_criterion(state):
    assert state.value in ROWS


def test_numbers_are_those_of_the_code():
    assert f"below {criteria.COHERENCE} or an unevenness above {criteria.UNEVENNESS}" in ROWS["irregular"]
    assert f"below {criteria.PLANAR}" in ROWS["spiral"]
    assert f"more than {criteria.LOBE} of" in ROWS["second bending"]
    assert f"< {criteria.ROLLING_SLIP}" in ROWS["rolling along the wall"]
    assert f"fewer than {criteria.FEWEST_SAMPLES:g} samples" in ROWS["not observable"]
    assert f"above {criteria.CONTACT_RADIUS} of the clearance" in ROWS["contact fraction"]
    assert f"{100 * criteria.ONSET_RADIUS:g} % of the clearance for one revolution" in " ".join(PAGE.split())
    assert BitMotion.STICK_SLIP.value in PAGE


def test_measured_figures_are_there():
    page = (ROOT / "evidence" / "docs" / "detection.md").read_text("utf-8")
    printed = page.partition("<!-- score")[2].partition("<!-- end of score")[0]
    assert re.search(r"\| all kinematic \| \d+ \| \d+ \| \d+ / \d+ \|", printed)
    assert re.search(r"\| rolling along the wall \| 0\.\d+ / 0\.\d+", printed)
