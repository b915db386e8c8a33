# SPDX-License-Identifier: Apache-2.0
"""The page shows that a simulator compiles, how far it is, and when it is heard no more meanwhile."""

from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS
from drill_twin_dashboard.live.page_state import PageState
from drill_twin_dashboard.live.shown import Sources


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


def _simulator(text, values):
    return encode_diagnostics(0, [Status("rig2/simulator", Level.OK, text, values)])


def test_progress_of_a_compilation_its_end_and_its_death():
    clock = Clock()
    page = PageState(Sources(clock))
    for functions in (12, 240):
        text = f"compiling the effects of the scene: {functions} functions, 3 s"
        page.update(DIAGNOSTICS, _simulator(text, {"compiling": text}))
        assert page.snapshot()["simulator"] == {"factor": "", "text": text}
    clock.now += 10.0
    assert "no diagnostics for 10 s" in page.snapshot()["simulator"]["text"]
    page.update(DIAGNOSTICS, _simulator("it is not configured", {"compiling": ""}))
    assert page.snapshot()["simulator"]["text"] == "it is not configured"
    page.update(DIAGNOSTICS, _simulator("fine", {"realtime_factor": "1.0", "pace": "realtime"}))
    assert page.snapshot()["simulator"] == {"factor": "1.0", "text": "realtime"}
