# SPDX-License-Identifier: Apache-2.0
"""`drill-twin watch` from the command line: a folder without a bag, the running twin by its word or its options."""

import re
import signal

import pytest
from browser import get

from drill_twin.ros import entry_points


def test_without_a_bag_it_serves_the_folder_until_ctrl_c(start, inside):
    page = start("watch", "--no-browser", "--port", "0")
    line = page.stdout.readline()
    place = re.match(r"this folder at http://(127\.0\.0\.1:\d+)/#code=[\w-]{32} \(for one browser, within 5 min", line)
    assert place, line
    assert b"Scenes of this folder" in get(place[1], "/")[1]
    page.send_signal(signal.SIGTERM)
    assert page.wait(60.0) == 0
    assert page.stderr.read() == ""
    assert list(inside.iterdir()) == []


@pytest.mark.parametrize(
    "given",
    [
        ["live"], ["--namespace", "rig2"], ["--limit", "wob_low=10 N"], ["--units", "si"], ["--foxglove", "8765"],
        ["live", "--foxglove", "8765"],
    ],
)  # fmt: skip
def test_the_word_live_and_options_of_a_twin_mean_the_running_twin(call, monkeypatch, given):
    started = []
    monkeypatch.setattr(entry_points, "start", lambda name, words: started.append((name, words)) or 0)
    assert call("watch", "--no-browser", *given).code == 0
    ((name, words),) = started
    assert name == "watch"
    assert words[:2] == ["--host=127.0.0.1", "--port=8000"]
    assert "live" not in words


def test_a_bag_that_is_named_live_is_played_by_its_path(call, inside):
    (inside / "live").mkdir()
    said = call("watch", "./live", "--no-browser")
    assert said.code == 2
    assert said.err.startswith("drill-twin: error: live: ")
