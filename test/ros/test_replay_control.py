# SPDX-License-Identifier: Apache-2.0
"""Replay in hand: pause, one message at a time, rate, seek, and what a replay leaves to the running nodes."""

import signal
from types import SimpleNamespace

import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.decode import JointStateReader, read_clock
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, MARKS_STATE, RIG_STATE, TF, TWIN_SCENE
from drill_twin.ros.bag import player_control
from drill_twin.ros.bag.player_control import PlayerControl, Playhead


def _stamps(raws):
    return [JointStateReader().read(bytes(raw)).stamp for raw in raws]


def _do(bench, action):
    answer = bench.call(f"/replayer/{action}")
    return answer.success, answer.message


def _over(bench, replayer):
    bench.until(lambda: replayer.code is not None, what="the end of the replay")
    assert replayer.code == 0, bench.logs()
    bench.drain()


def test_a_replay_is_paused_stepped_sped_up_and_begun_again(bench, small_bag):
    bag = Bag(small_bag)
    rows = list(bag.messages((RIG_STATE,)))
    recorded, half = _stamps(raw for _, _, raw in rows), len(rows) // 2
    middle = (rows[half][1] - bag.start) * 1e-9
    states, clocks, scenes = bench.collect(RIG_STATE), bench.collect(CLOCK_TOPIC), bench.collect(TWIN_SCENE)
    analyzer = bench.start("analyzer")
    findings = "/whirl/state /whirl/motion /whirl/onset /twin/summary"
    replayer = bench.start(
        "replayer", bag=str(small_bag), start_offset=middle, start_paused=True, rate=0.01, wait_for="analyzer",
        leave_out=findings,
    )  # fmt: skip
    bench.until_ready("replayer")
    assert not states
    while not states:
        assert _do(bench, "play_next")[0]
    bench.drain()
    assert len(states) == 1
    assert _stamps(states)[0] in recorded[half - 1 : half + 2]
    status = bench.until_status("replayer", lambda status: status.values["paused"] == "true")
    assert float(status.values["place"]) > middle - 0.001
    # Back to the beginning while it is paused: the clock goes back, and the scene begins another run.
    before = len(clocks), len(scenes)
    assert bench.set_parameter("replayer", "start_offset", 0.0).successful
    bench.until(lambda: len(scenes) > before[1], what="the scene of the next run")
    assert _do(bench, "resume")[0]
    assert bench.set_parameter("replayer", "rate", 1000.0).successful
    _over(bench, replayer)
    assert read_clock(bytes(clocks[before[0]])) < read_clock(bytes(clocks[before[0] - 1]))
    assert _stamps(states)[1:] == recorded
    status = bench.until_status("analyzer", lambda status: int(status.values["samples"]) == len(recorded))
    assert (status.values["runs"], status.values["late"]) == ("2", "0")
    assert analyzer.end() == 0


def test_a_replay_refuses_a_place_outside_and_a_step_while_it_plays(bench, small_bag):
    replayer = bench.start("replayer", bag=str(small_bag), rate=0.001)
    bench.until_ready("replayer")
    assert not _do(bench, "play_next")[0]
    assert "expected a paused replay" in _do(bench, "play_next")[1]
    assert "expected a place in the bag" in bench.set_parameter("replayer", "start_offset", 1e6).reason
    assert _do(bench, "toggle_paused")[1].startswith("paused at ")
    assert _do(bench, "toggle_paused")[1].startswith("going on at ")
    assert _do(bench, "stop")[0]
    assert replayer.wait() == 0, replayer.text


class _Node:
    """A replayer as the services hold it in hand."""

    def __init__(self):
        self.rate, self.ended, self.active = 0.0, False, True

    def get_name(self):
        return "replayer"

    def set_parameters(self, parameters):
        self.rate = parameters[0].value
        return [SimpleNamespace(successful=self.rate > 0.0)]

    def end(self):
        self.ended = True


def test_the_services_of_rosbag2_answer_in_its_fields():
    """Types of the package rosbag2_interfaces are not in the wheels; the functions that answer are the same."""
    head, node = Playhead(0.0, 2.0, paused=False), _Node()
    control = PlayerControl(head, 100 * 10**9, 12.0, node)

    def ask(service, fields, **given):
        response = SimpleNamespace(**dict.fromkeys(fields))
        player_control._answering(getattr(control, service))(SimpleNamespace(**given), response)
        return vars(response)

    assert ask("get_rate", ["rate"]) == {"rate": 2.0}
    assert ask("set_rate", ["success"], rate=3) == {"success": True}
    assert node.rate == 3.0
    assert ask("set_rate", ["success"], rate=-3) == {"success": False}
    assert ask("burst", ["actually_burst"], num_messages=3) == {"actually_burst": None}
    assert ask("pause", ["structure_needs_at_least_one_member"]) == {"structure_needs_at_least_one_member": None}
    assert ask("is_paused", ["paused"]) == {"paused": True}
    assert ask("burst", ["actually_burst"], num_messages=3) == {"actually_burst": 3}
    assert (head.singles, head.waits) == (3, True)
    assert ask("seek", ["success"], time=SimpleNamespace(sec=104, nanosec=500_000_000)) == {"success": True}
    assert head.target == 4.5
    assert ask("seek", ["success"], time=SimpleNamespace(sec=99, nanosec=0)) == {"success": False}
    with pytest.raises(DrillTwinError, match=r"0 to 12.000 s, found -1.000 s"):
        control.go_to(-1.0)
    ask("stop", [])
    assert node.ended
    assert set(player_control.SERVICES) == {name for name in vars(PlayerControl) if name[0] != "_"} - {"go_to", "check"}


def test_recorded_diagnostics_and_frames_are_not_mixed_with_what_runs(bench, small_bag, tmp_path):
    """Recorded words of a simulator would be those of a running one; frames need tf2_msgs."""
    with BagWriter(tmp_path / "more_0", topics=[*Bag(small_bag).topics, TF]) as bag:
        for row in Bag(small_bag).messages():
            bag.write(*row)
        bag.write(TF, row[1], row[2])
    assert Bag(small_bag).topics[DIAGNOSTICS].count
    heard = bench.collect(DIAGNOSTICS)
    replayer = bench.start("replayer", bag=str(tmp_path / "more_0"), rate=0.0, wait_for="test")
    _over(bench, replayer)
    assert {status.name for raw in heard for status in decode_diagnostics(bytes(raw))[1]} == {"replayer"}
    assert "left out, as their message package is not installed: /tf" in replayer.text
    named = bench.start("replayer", bag=str(small_bag), rate=0.0, wait_for="test", topics=DIAGNOSTICS)
    _over(bench, named)
    assert "simulator" in {status.name for raw in heard for status in decode_diagnostics(bytes(raw))[1]}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_replay_without_end_ends_on_a_signal(bench, small_bag, number):
    replayer = bench.start("replayer", bag=str(small_bag), topics=MARKS_STATE, rate=0.0, loop=True)
    bench.until_status("replayer", lambda status: int(status.values["messages"]) > 2 * Bag(small_bag).message_count)
    assert replayer.end(number) == 0, replayer.text
