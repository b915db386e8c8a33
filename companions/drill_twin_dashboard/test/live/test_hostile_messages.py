# SPDX-License-Identifier: Apache-2.0
"""Messages of a hostile node on the topics of the page: it stays small, and its texts stay one line of plain text."""

import json

import numpy as np
import pytest

from drill_twin.io.messages.cdr import JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.topics import DIAGNOSTICS, MARKS_STATE, STRING_POSES, WHIRL_MOTION, WHIRL_ONSET
from drill_twin.io.messages.whirl_encode import OnsetMessage, SubjectMotion, encode_motion, encode_onset
from drill_twin_dashboard.live.page_state import PageState
from drill_twin_dashboard.live.shown import Sources

LARGEST = 200_000  # bytes of a picture
ODD = "a\x1b[2J\n\u202e" + "x" * 100_000


def marks(names):
    names = [f"{name}/{axis}" for name in names for axis in MARK_AXES]
    return JointStateTemplate(names, velocity=False, effort=False).fill(0, np.zeros(len(names)))


@pytest.mark.slow
def test_the_picture_stays_small_and_plain():
    page = PageState(Sources())
    for turn in range(15):
        page.update(MARKS_STATE, marks([f"mark_{turn}_{k}" for k in range(20)]))
        page.update(DIAGNOSTICS, encode_diagnostics(0, [Status(f"{turn}_{k}", Level.OK, "fine") for k in range(20)]))
    page.update(STRING_POSES, PoseArrayTemplate(30_000).fill(0, np.zeros((30_000, 3)), np.zeros((30_000, 4))))
    page.update(WHIRL_MOTION, encode_motion(0, [SubjectMotion("string", ODD, ODD), SubjectMotion(ODD, ODD, ODD)]))
    page.update(WHIRL_ONSET, encode_onset(0, OnsetMessage(1.0, ODD)))
    values = {"realtime_factor": ODD, "pace": ODD, "state": "running"}
    page.update(
        DIAGNOSTICS, encode_diagnostics(0, [Status("simulator", Level.OK, ODD, values), Status(ODD, Level.OK, ODD)])
    )
    picture = page.snapshot()
    text = json.dumps(picture, ensure_ascii=False)
    assert len(text) < LARGEST
    assert text.isprintable()
    assert len(picture["marks"]) <= 200
    assert len(picture["graph"]) <= 200
    assert any(row["name"] == "simulator" for row in picture["graph"])
    assert page.skipped
