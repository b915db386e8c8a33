# SPDX-License-Identifier: Apache-2.0
"""All nodes in one process make the same run as one process each."""

from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    REALTIME_FACTOR,
    RIG_COMMAND,
    RPS_COMMAND,
    TOPICS,
    TWIN_SCENE,
    WOB_COMMAND,
)

COMMANDS = (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND)


def test_one_process_makes_the_same_run(bench, small_bag, payloads):
    folder = bench.folder / "bag_0"
    process = bench.start("twin", pace="lockstep", duration=0.5, record=True, bag=str(folder))
    bench.until(lambda: process.code is not None, what="the run to end")
    assert process.code == 0, process.text
    assert "Traceback" not in process.text
    for topic in set(TOPICS) - {DIAGNOSTICS, TWIN_SCENE, REALTIME_FACTOR}:
        one, several = payloads(folder, topic), payloads(small_bag, topic)
        if topic in COMMANDS and len(one) == len(several) - 1:
            several.pop()  # for the frame after the last: the driver of one process may be stopped before it sends it
        assert one == several, topic


def test_the_whole_process_ends_when_one_of_its_nodes_cannot_start(bench):
    (bench.folder / "bag_0").mkdir()
    process = bench.start("twin", record=True, bag=str(bench.folder / "bag_0"))
    bench.until(lambda: process.code is not None, what="the process to end")
    assert process.code == 2, process.text
    assert "exists" in process.text
    assert "Traceback" not in process.text


def test_what_the_user_gives_stands_before_what_the_process_sets(bench):
    process = bench.start("twin", wait_for="nobody", wait_timeout=1.0)
    bench.until(lambda: process.code is not None, what="the end of the wait")
    assert "waited 1 s for the node /nobody" in process.text
