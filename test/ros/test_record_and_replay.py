# SPDX-License-Identifier: Apache-2.0
"""Live findings agree with those in the bag, of a replay, and of a second run in lockstep."""

import itertools
import re
import signal
import sys
import time
from dataclasses import replace

import pytest

import drill_twin
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.decode import JointStateReader, read_clock
from drill_twin.io.messages.stamps import pack_stamp
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    COMMANDER,
    DIAGNOSTICS,
    MARKS_STATE,
    OF_EVERY_RUN,
    REALTIME_FACTOR,
    RIG_COMMAND,
    RIG_STATE,
    RPS_COMMAND,
    STRING_POSES,
    TWIN_SCENE,
    TWIN_SUMMARY,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
    WOB_COMMAND,
)
from drill_twin.io.whirl_pipeline import WhirlPipeline
from drill_twin.ros.entry_points import REPLAY, waits

INPUTS = (TWIN_SCENE, MARKS_STATE, RIG_STATE)
"""Topics that the analysis needs."""

FINDINGS = (WHIRL_STATE, WHIRL_MOTION, WHIRL_ONSET, TWIN_SUMMARY)
# A weight far above the buckling load at once, so that whirl begins within the first second.
EAGER = "rig.weight_on_bit.duration=0.5 s; wob=60; rig.rotation.duration=0.5 s; effects.bow.amplitude=2 mm"
DURATION = 3.0


@pytest.fixture(scope="module")
def eager_bag(tmp_path_factory, module_bench):
    folder = tmp_path_factory.mktemp("eager")
    return _run(module_bench(folder), folder / "bag_0")


def _run(bench, bag):
    simulator = bench.start("simulator", pace="lockstep", overrides=EAGER, duration=DURATION)
    analyzer, recorder = bench.start("analyzer"), bench.start("recorder", bag=str(bag))
    driver = bench.start("rig_driver", overrides=EAGER, wait_for="simulator analyzer recorder")
    bench.until(lambda: simulator.code is not None, 120.0, "the run to end")
    assert simulator.code == 0, bench.logs()
    for process in (driver, analyzer, recorder):
        assert process.end() == 0, bench.logs()
        assert "Traceback" not in process.text
    return bag


def test_a_recorded_run_is_whole(eager_bag):
    bag = Bag(eager_bag)
    assert not bag.truncated
    frames = round(DURATION * 100)
    for topic in (RIG_STATE, MARKS_STATE, STRING_POSES, WHIRL_STATE):
        assert bag.topics[topic].count == frames
    assert all(bag.topics[topic].count for topic in OF_EVERY_RUN)
    stamps = [read_clock(raw) for _, _, raw in bag.messages((CLOCK_TOPIC,))]
    # the clock of time zero is latched for late drivers; a recorder need not have been there yet
    assert stamps[-frames:] == [k * 10_000_000 for k in range(1, frames + 1)]
    assert stamps[:-frames] in ([], [0])


def test_the_live_findings_are_those_of_the_bag(eager_bag, payloads):
    pipeline = WhirlPipeline()
    again = {topic: [] for topic in FINDINGS}
    for topic, _, raw in Bag(eager_bag).messages(INPUTS):
        for found, message in pipeline.analyse(topic, raw):
            kept = message[:-16] + message[-8:] if found == TWIN_SUMMARY else message  # no real-time factor
            again[found].append(kept + bytes(-len(kept) % 4))
    assert again == {topic: payloads(eager_bag, topic) for topic in FINDINGS}
    assert pipeline.findings.onset is not None, "the run was meant to whirl"


@pytest.mark.parametrize("rate", [pytest.param(0.0, marks=pytest.mark.long), 4.0])  # 0 also in the test below
def test_a_replay_gives_the_same_findings(bench, eager_bag, payloads, tmp_path, rate):
    # The recorder writes what the analyzer finds on the replay; all messages come back byte for byte.
    again = tmp_path / "again_0"
    analyzer, recorder = bench.start("analyzer"), bench.start("recorder", bag=str(again))
    replayer = bench.start(
        "replayer", bag=str(eager_bag), rate=rate, leave_out=" ".join(FINDINGS), wait_for="analyzer recorder"
    )
    assert replayer.wait() == 0, bench.logs()
    for process in (analyzer, recorder):
        assert process.end() == 0, bench.logs()
    topics = (*FINDINGS, MARKS_STATE, RIG_STATE, STRING_POSES, RIG_COMMAND, TWIN_SCENE, CLOCK_TOPIC)
    for topic in topics:
        assert payloads(again, topic) == payloads(eager_bag, topic), topic


def test_a_replay_with_the_parameters_of_the_launch_waits_for_an_analyzer_that_comes_late(bench, eager_bag):
    computed = {
        "leave_out": " ".join(FINDINGS),
        "keep_namespace": False,
        "wait_timeout": 120.0,
        "wait_for": " ".join(waits("replayer", REPLAY)["wait_for"]),
    }
    replayer = bench.start("replayer", bag=str(eager_bag), rate=0.0, **computed)
    bench.until(lambda: "waiting for /analyzer: it is not there yet" in replayer.text, what="the wait")
    found = bench.collect(WHIRL_STATE)
    analyzer = bench.start("analyzer")
    assert replayer.wait() == 0, bench.logs()
    assert analyzer.end() == 0, bench.logs()
    bench.drain()
    assert len(found) == Bag(eager_bag).topics[WHIRL_STATE].count


def test_a_split_bag_of_another_recorder_gives_the_same_findings_under_our_names(bench, eager_bag, payloads, tmp_path):
    theirs = {MARKS_STATE: "/camera/marks", RIG_STATE: "/autodriller/state"}
    bag = Bag(eager_bag)
    topics = [replace(topic, name=theirs.get(name, name), count=0) for name, topic in bag.topics.items()]
    with BagWriter(tmp_path / "theirs", topics=topics, longest=0.3) as writer:
        for name, stamp, raw in bag.messages():
            if name not in FINDINGS:
                writer.write(theirs.get(name, name), stamp, raw)
    assert writer.files > 3
    again = tmp_path / "again_0"
    analyzer, recorder = bench.start("analyzer"), bench.start("recorder", bag=str(again))
    maps = [word for ours, name in theirs.items() for word in ("--remap", f"{name}={ours}")]
    waits = ["--wait-for", "analyzer", "--wait-for", "recorder"]
    command = [sys.executable, "-m", "drill_twin.cli", "replay", str(writer.folder), "--rate", "0", *maps, *waits]
    assert bench.command("replay", command).wait() == 0, bench.logs()
    for process in (analyzer, recorder):
        assert process.end() == 0, bench.logs()
    for topic in (*FINDINGS, MARKS_STATE, RIG_STATE, TWIN_SCENE):
        assert payloads(again, topic) == payloads(eager_bag, topic), topic


def test_a_replay_leaves_out_what_no_node_could_use_and_says_so(bench, small_bag, tmp_path):
    rows = list(Bag(small_bag).messages())
    stamp = rows[-1][1]
    odd = [(RIG_STATE, stamp, b"\0\1\0\0rubbish"), (RIG_STATE, stamp, b""), (MARKS_STATE, 2**62, rows[-1][2])]
    with BagWriter(tmp_path / "odd_0") as bag:
        for row in (*rows, *odd):
            bag.write(*row)
    replayer = bench.start("replayer", bag=str(tmp_path / "odd_0"), rate=10.0)
    bench.until(lambda: replayer.code is not None, 60.0, "the end of the replay")
    assert replayer.code == 0, replayer.text
    assert "left out: 2 messages on /rig/state could not be used, the first at" in replayer.text
    assert "left out: 1 message on /marks/state not usable" in replayer.text
    assert "Traceback" not in replayer.text


def test_a_replay_keeps_its_time(bench, eager_bag):
    times = []
    bench.subscribe(RIG_STATE, lambda _: times.append(time.monotonic()))
    bag = Bag(eager_bag)
    stamps = [stamp * 1e-9 for _, stamp, _ in bag.messages((RIG_STATE,))]
    replayer = bench.start("replayer", bag=str(eager_bag), rate=2.0, wait_for="test")
    bench.until(lambda: replayer.code is not None)
    assert replayer.code == 0, replayer.text
    bench.drain()
    assert len(times) == len(stamps)
    # Never early, counted from when it asked whether the test was ready; late as far as the machine is busy.
    assert times[-1] - bench.asked_ready >= 0.5 * (stamps[-1] - stamps[0])


def test_two_runs_in_lockstep_are_alike(bench, eager_bag, payloads, tmp_path):
    again = _run(bench, tmp_path / "again_0")
    topics = set(OF_EVERY_RUN) - {COMMANDER, DIAGNOSTICS, TWIN_SCENE, REALTIME_FACTOR}  # these tell wall time
    for topic in topics:
        first, second = payloads(eager_bag, topic), payloads(again, topic)
        if topic == CLOCK_TOPIC:  # but for that of time zero
            first, second = first[-round(DURATION * 100) :], second[-round(DURATION * 100) :]
        assert second == first, topic


def test_a_recorder_takes_what_its_four_parameters_let_pass(bench, small_bag, tmp_path):
    topics = {
        "twice": {"topics": f"{RIG_STATE} {MARKS_STATE} {RIG_STATE}"},
        "regex": {
            "topics": CLOCK_TOPIC,
            "regex": "^/rig/.*",
            "exclude_topics": RIG_COMMAND,
            "exclude_regex": "mander$",
        },
    }
    recorders = {
        name: bench.start("recorder", "-r", f"__node:={name}", bag=str(tmp_path / f"{name}_0"), **given)
        for name, given in topics.items()
    }
    replayer = bench.start("replayer", bag=str(small_bag), rate=0.0, wait_for="twice regex")
    assert replayer.wait() == 0, bench.logs()
    for recorder in recorders.values():
        assert recorder.end() == 0, bench.logs()
    bags = {name: {topic: held.count for topic, held in Bag(tmp_path / f"{name}_0").topics.items()} for name in topics}
    count = Bag(small_bag).topics[RIG_STATE].count
    assert bags["twice"] == {RIG_STATE: count, MARKS_STATE: count}
    assert set(bags["regex"]) == {CLOCK_TOPIC, RIG_STATE, RPS_COMMAND, WOB_COMMAND}
    assert bags["regex"][RIG_STATE] == count


@pytest.mark.fault("recorder killed (-9)", "all but the last second can be read")
def test_a_killed_recorder_leaves_a_readable_bag(bench, tmp_path):
    simulator = bench.start("simulator", wait_for_command=False)
    recorder = bench.start("recorder", bag=str(tmp_path / "bag_0"), max_bagfile_duration=0.6)
    bench.until_ready("simulator", "recorder")
    frames = bench.collect(RIG_STATE)
    bench.until(lambda: len(frames) > 200)
    recorder.send(signal.SIGKILL)
    last = JointStateReader().read(bytes(frames[-1])).stamp
    recorder.kill()
    assert simulator.end() == 0
    bag = Bag(tmp_path / "bag_0")
    assert bag.truncated
    assert len(list((tmp_path / "bag_0").glob("*.mcap"))) >= 3
    stamps = [JointStateReader().read(raw).stamp for _, _, raw in bag.messages((RIG_STATE,))]
    assert last - stamps[-1] < 1_000_000_000  # all but the last second at most
    assert stamps == sorted(stamps)


@pytest.mark.fault("recorder stopped for a while", "it counts and reports what it lost")
def test_a_recorder_says_what_it_lost(bench, tmp_path):
    from drill_twin.io.messages.rig_messages import CommandEncoder
    from drill_twin.scene.set_points import Command

    recorder = bench.start("recorder", bag=str(tmp_path / "bag_0"))
    bench.until_ready("recorder")
    publisher = bench.publisher(RIG_COMMAND)
    raw = CommandEncoder().command(0, Command(1.0, 1.0))
    publisher.publish(raw)
    bench.until_status("recorder", lambda status: int(status.values["messages"]) > 1)
    recorder.send(signal.SIGSTOP)  # a recorder that cannot keep up
    for _ in range(5000):
        publisher.publish(raw)
    recorder.send(signal.SIGCONT)
    sent = itertools.count(5002)

    def has_lost(status):  # what is lost at the very end shows only when something follows it
        publisher.publish(raw)
        return next(sent) and int(status.values["lost"]) > 0

    status = bench.until_status("recorder", has_lost)
    assert status.level == 1
    assert f"lost {RIG_COMMAND}" in status.values
    assert recorder.end() == 1
    assert f"of {RIG_COMMAND}" in recorder.text
    counted = Bag(tmp_path / "bag_0").topics[RIG_COMMAND].count
    assert "Traceback" not in recorder.text
    lost = re.search(rf"(\d+) of {RIG_COMMAND}", recorder.text)
    assert lost, recorder.text
    assert counted > 1
    assert counted + int(lost.group(1)) < next(sent)


@pytest.mark.fault("analyzer stopped for a while", "it warns of what it lost, until it is cleaned up")
def test_an_analyzer_says_what_it_lost(bench, small_bag):
    analyzer = bench.start("analyzer", marks_scene="pa6_bench")
    samples = {topic: next(bytes(raw) for *_, raw in Bag(small_bag).messages((topic,))) for topic in INPUTS[1:]}
    publishers = {topic: bench.publisher(topic) for topic in samples}
    frames = itertools.count(1)

    def publish():
        stamp = next(frames) * 10_000_000
        for topic, raw in samples.items():
            stamped = bytearray(raw)
            pack_stamp(stamped, 4, stamp)
            publishers[topic].publish(bytes(stamped))
        return True

    status = bench.until_status("analyzer", lambda status: publish() and int(status.values["samples"]) > 10)
    assert status.level == 0
    analyzer.send(signal.SIGSTOP)
    for _ in range(3000):
        publish()
    analyzer.send(signal.SIGCONT)
    bench.until_status("analyzer", lambda status: publish() and int(status.values["dropped"]) > 0)
    status = bench.until_status("analyzer", lambda status: publish() and "no good sample" not in status.text)
    assert status.level == 1
    assert "messages were dropped unread, as this node was too slow for them" in status.text
    assert analyzer.end() == 0


@pytest.mark.fault("disk full while recording", "the recorder ends with the reason; the bag keeps what it has")
def test_a_recorder_that_cannot_write_any_more_says_so_and_keeps_what_it_has(bench, tmp_path):
    bag = tmp_path / "bag_0"
    # A limit on the size of a file fails writes in mid-run, as a full disk does.
    limited = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000)); "
        "from drill_twin.ros.entry_points import start; sys.exit(start('recorder', sys.argv[1:]))"
    )
    command = [sys.executable, "-c", limited, "--ros-args", "-p", f"bag:={bag}"]
    recorder = bench.command("recorder", command, FASTDDS_BUILTIN_TRANSPORTS="UDPv4")  # shared memory is a file too
    simulator = bench.start("simulator", wait_for_command=False)
    bench.until(lambda: recorder.code is not None, 90.0, "the recorder to give up")
    assert recorder.code == 1, recorder.text
    assert f"recorder: error: {bag}/bag_0.mcap: expected to go on writing the bag" in recorder.text
    assert "Traceback" not in recorder.text
    assert simulator.end() == 0
    assert Bag(bag).topics[RIG_STATE].count > 100


@pytest.mark.fault("disk full while recording", "the recorder's status says what is lost, and from when on")
def test_a_recorder_on_a_full_disk_reports_what_is_lost(bench, small_disk):
    bag = small_disk(400 * 1024) / "bag_0"
    recorder = bench.start("recorder", bag=str(bag))
    simulator = bench.start("simulator", wait_for_command=False)
    status = bench.until_status("recorder", lambda status: status.level == 2)
    assert recorder.wait() == 1, recorder.text
    assert simulator.end() == 0
    said = re.search(
        r"found No space left on device; messages are lost, (\d+) so far; (\d+) earlier messages",
        status.text,
    )
    assert said, status.text
    lost, kept = map(int, said.groups())
    assert int(status.values["lost"]) == lost > 0
    assert int(status.values["messages"]) == kept
    assert f"{kept} messages recorded, lost: {lost} in the bag and all that came after" in recorder.text
    assert "Traceback" not in recorder.text
    read = Bag(bag)
    assert sum(1 for _ in read.messages()) == kept > 100
    assert "name: pa6_bench" in read.scene()


@pytest.mark.fault("simulator gone", "the analyzer says so within seconds and takes up the next run")
def test_an_analyzer_reports_that_samples_stopped_coming(bench):
    simulator, analyzer = bench.start("simulator", wait_for_command=False), bench.start("analyzer")
    bench.until_status("analyzer", lambda status: int(status.values["samples"]) > 50)
    simulator.kill()
    status = bench.until_status("analyzer", lambda status: "no good sample of /marks/state for" in status.text)
    assert status.level == 3
    # It takes up a new run by itself.
    simulator = bench.start("simulator", wait_for_command=False)
    bench.until_status("analyzer", lambda status: status.values["runs"] == "2" and status.level == 0)
    assert simulator.end() == 0
    assert analyzer.end() == 0


def test_the_onset_reaches_who_joins_late(bench, eager_bag, payloads):
    analyzer = bench.start("analyzer")
    replayer = bench.start("replayer", bag=str(eager_bag), rate=0.0, leave_out=" ".join(FINDINGS), wait_for="analyzer")
    assert replayer.wait() == 0, bench.logs()
    late = bench.collect(WHIRL_ONSET, latched=True)
    bench.until(lambda: late and bytes(late[-1]) == payloads(eager_bag, WHIRL_ONSET)[-1], what="the onset")
    assert analyzer.end() == 0


def test_a_bag_in_lockstep_is_computed_again_bit_for_bit(small_bag):
    both = drill_twin.rerun(small_bag)
    assert both.commands.source == RIG_COMMAND
    assert both.identical
