# SPDX-License-Identifier: Apache-2.0
"""A recording opens shortly before the onset of whirl, with the motion that led there."""

import time
from collections import Counter

import pytest

from drill_twin.report.quantities import loads, string_weight
from drill_twin.report.recording import read_recording
from drill_twin_dashboard.live.player import Player


@pytest.fixture
def player(bench_run, monkeypatch):
    monkeypatch.setattr("drill_twin_dashboard.live.player._LEAD", 0.3)  # the run begins to whirl at 0.66 s
    player = Player(next(bench_run.bag.glob("*.mcap")).parent)
    yield player
    player.close()


def until(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_page_opens_before_the_onset_and_plays(player, bench_run):
    onset = read_recording(bench_run.bag).summary.onset_s
    first = player.snapshot()["player"]
    assert not first["playing"]  # no page is open
    assert first["at"] == first["begin"] == pytest.approx(onset - 0.3, abs=0.05)
    until(lambda: player.snapshot()["time"] == pytest.approx(first["begin"], abs=0.05))
    player.on_request({"seek": first["begin"], "play": True})  # as the page does
    trails = Counter()  # each snapshot takes what has come since the one before
    until(
        lambda: (
            trails.update({k: len(v) for k, v in player.snapshot()["trail"].items()})
            or max(trails.values(), default=0) > 20
        )
    )
    until(lambda: player.snapshot()["player"]["at"] > first["begin"])
    assert player.snapshot()["player"]["playing"]


def test_a_page_that_opens_at_the_end_begins_anew(player):
    player.on_request({"seek": player.length})
    until(lambda: player.snapshot()["time"] > player.beginning + 0.5)
    player.on_request({"seek": player.beginning, "play": True})
    assert player.snapshot()["player"]["at"] < player.length
    assert player.snapshot()["player"]["playing"]


def test_a_page_shows_the_loads_of_the_rig(player, bench_run):
    recording = read_recording(bench_run.bag)
    until(lambda: player.snapshot()["rig"])
    picture = player.snapshot()
    shown, rig = picture["rig"], recording.rig
    k = int(abs(rig.hookload - shown["hookload"]).argmin())
    assert rig.time[k] == pytest.approx(picture["time"], abs=0.05)
    assert (shown["hookload"], shown["bit_torque"]) == (rig.hookload[k], rig.bit_torque[k])
    assert shown["drag"] == rig.hookload[k] + rig.bit_force[k] - string_weight(recording.scene)
    whole = loads(recording, {})["drag_n"]
    assert whole["min"] <= shown["drag"] <= whole["max"]
