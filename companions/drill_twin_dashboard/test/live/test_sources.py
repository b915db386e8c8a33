# SPDX-License-Identifier: Apache-2.0
"""Values of a source that is heard no more become stale and disappear; the values of a paused twin stay."""

import pytest

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.topics import RIG_STATE, STRING_POSES, WHIRL_STATE
from drill_twin_dashboard.live.shown import Sources


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def sources(clock):
    return Sources(clock)


def _second(sources, clock, *, frames=True, state="running", nodes=("simulator", "analyzer", "recorder")):
    """A second of a twin: diagnostics of its nodes at the start, and frames."""
    for name in nodes:
        sources.report(Status(name, Level.OK, "fine", {"state": state} if name == "simulator" else {}))
    for _ in range(10):
        if frames:
            sources.message(STRING_POSES)
            sources.message(WHIRL_STATE)
        clock.now += 0.1


def test_before_the_first_message_there_is_no_age(sources):
    assert sources.age("simulator") is sources.age("analyzer") is None


def test_the_age_of_a_killed_simulator_is_that_of_its_last_frame(sources, clock):
    _second(sources, clock)
    last = clock.now - 0.1
    for _ in range(30):
        clock.now += 0.1
        assert sources.age("simulator") == pytest.approx(clock.now - last)


def test_a_paused_twin_is_alive_while_its_diagnostics_come(sources, clock):
    _second(sources, clock)
    for _ in range(10):
        _second(sources, clock, frames=False, state="paused")
        assert sources.age("simulator") < 1.0
        assert sources.age("analyzer") < 1.0
    clock.now += 3.1
    assert sources.age("simulator") > 3.0


def test_an_analyzer_that_dies_is_old_while_the_simulator_runs(sources, clock):
    _second(sources, clock)
    for _ in range(40):
        sources.message(RIG_STATE)
        clock.now += 0.1
    assert sources.age("simulator") < 1.0
    assert sources.age("analyzer") > 3.0


def test_a_node_that_is_silent_is_told_and_one_that_has_ended_is_not(sources, clock):
    _second(sources, clock)
    sources.report(Status("rig_driver", Level.OK, "driving", {"ended": "true"}))
    for _ in range(4):
        _second(sources, clock, nodes=("simulator", "analyzer"))
    assert [row["name"] for row in sources.nodes() if row["age"] > GONE] == ["recorder"]
    rows = {row["name"]: row for row in sources.nodes()}
    assert set(rows) == {"simulator", "analyzer", "recorder"}
    assert rows["simulator"]["text"] == "fine"
    assert rows["recorder"]["text"] == "no diagnostics for 5 s"
    assert rows["recorder"]["level"] == Level.ERROR
    clock.now += 60.0
    assert sources.nodes() == []
