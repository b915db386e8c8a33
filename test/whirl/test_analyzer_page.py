# SPDX-License-Identifier: Apache-2.0
"""docs/analyzer.md names every state with the numbers that the code has; the measured figures are with the evidence."""

import re
from pathlib import Path

import pytest

from drill_twin.whirl import BitMotion, Criteria, MotionState

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "analyzer.md").read_text("utf-8")
ROWS = {line.split("|")[1].strip(): line for line in reversed(PAGE.splitlines()) if line.startswith("| ")}


@pytest.mark.parametrize("state", MotionState, ids=lambda state: state.value)
def test_every_state_has_its_criterion(state):
    assert state.value in ROWS


def test_numbers_are_those_of_the_code():
    rules = Criteria()
    assert f"below {rules.coherence} or an unevenness above {rules.unevenness}" in ROWS["irregular"]
    assert f"below {rules.planar}" in ROWS["spiral"]
    assert f"more than {rules.lobe} of" in ROWS["second bending"]
    assert f"< {rules.rolling_slip}" in ROWS["rolling along the wall"]
    assert f"fewer than {rules.fewest_samples:g} samples" in ROWS["not observable"]
    assert f"above {rules.contact_radius} of the clearance" in ROWS["contact fraction"]
    assert f"{100 * rules.onset_radius:g} % of the clearance for one revolution" in " ".join(PAGE.split())
    assert BitMotion.STICK_SLIP.value in PAGE


def test_measured_figures_are_there():
    page = (ROOT / "evidence" / "docs" / "detection.md").read_text("utf-8")
    printed = page.partition("<!-- score")[2].partition("<!-- end of score")[0]
    assert re.search(r"\| kinematic signals \| \d+ \| \d+ \| \d+ of \d+ \(95 % interval", printed)
    assert re.search(r"\| macro-F1 \| \*\*0\.\d+\*\*", printed)
    assert re.search(r"24 h of four marks, \d+ onsets", printed)
