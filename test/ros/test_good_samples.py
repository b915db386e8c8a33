# SPDX-License-Identifier: Apache-2.0
"""Health of the nodes that consume data: what they say when nothing, or nothing good, comes, and in a pause."""

import json
import math
import re

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from ports import free_port

from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.encode import MARK_AXES, encode_string
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    ESTIMATE_STATE,
    MARKS_STATE,
    MEASURED_RIG_STATE,
    RIG_STATE,
    TOPICS,
    TWIN_SCENE,
)
from drill_twin.ros.core.topics import message_class, quality
from drill_twin.scene import load_scene

for package in ("drill_twin_dashboard", "drill_twin_studies"):
    pytest.importorskip(package, reason=f"needs the package {package}")

from drill_twin_dashboard.live.page_state import PageState  # noqa: E402
from drill_twin_dashboard.live.shown import Sources  # noqa: E402
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span  # noqa: E402
from drill_twin_studies.maps.runs import Key, RunRecord  # noqa: E402

COARSE = (
    "numerics.elements=8; numerics.step=10 ms; numerics.frame_rate=50 Hz; rig.rotation.duration=1 s; "
    "rig.weight_on_bit.duration=1 s"
)
"""Kernel of the paper's rod."""
NAN = [math.nan] * 4


def estimated(raw):
    state = read_joint_state(raw)
    return dict(zip(state.names, state.position.tolist(), strict=True))


class MeasuringRig:
    """A rig that measures fifty times a second what the scene has when it turns steadily, and noise."""

    def __init__(self, bench):
        self._bench, self._publisher = bench, bench.publisher(MEASURED_RIG_STATE)
        self._template, self._draw = JointStateTemplate(RIG_JOINTS), np.random.default_rng(1)
        self.number, self.step = 0, 1

    def measure(self, count, hookload=-28.5, torque=0.12):
        for _ in range(count):
            self.number += self.step
            torque_now, load = (value + 0.01 * self._draw.standard_normal() for value in (torque, hookload))
            raw = self._template.fill(20_000_000 * self.number, NAN, NAN, [torque_now, math.nan, load, math.nan])
            self._publisher.publish(bytes(raw))
            self._bench.spin(0.01)

    def until_told(self, wanted, **measured):
        """Go on to measure until the estimator's next status is the wanted one."""
        self._bench.statuses.pop("estimator", None)
        for _ in range(400):
            self.measure(10, **measured)
            status = self._bench.statuses.get("estimator")
            if status is not None and wanted(status):
                return status
        pytest.fail(f"the last status was {status}")


@pytest.fixture
def estimator(bench):
    process = bench.start(
        "estimator",
        overrides=COARSE,
        free="load_factor=0.7..1.3",
        members=5,
        show=False,
        horizon=0.0,
        set_points="scene",
        window=0.2,
        error=1.0,
    )  # fmt: skip  the rig is made up: it has neither the start nor the whirl of the scene
    bench.until_ready("estimator")
    yield process
    assert process.end() == 0, process.text
    assert "Traceback" not in process.text
    assert "Warning" not in process.text  # of scipy, on numbers of members that are no power of two


@pytest.mark.fault("a rig measures NaN only, then nothing", "the estimator says since when; its estimates are unusable")
def test_an_estimator_does_not_follow_a_rig_that_measures_nothing(bench, estimator):
    found, rig = bench.collect(ESTIMATE_STATE), MeasuringRig(bench)
    rig.until_told(lambda status: (status.level, status.text) == (Level.OK, "the model explains what is measured"))
    first = rig.number
    status = rig.until_told(lambda status: status.level == Level.ERROR, hookload=math.nan, torque=math.nan)
    assert status.text.startswith(f"no good sample of {MEASURED_RIG_STATE} for ")
    assert status.text.endswith("samples had no finite number)")
    while estimated(found[-1])["trust"] != Level.ERROR:  # unusable, by the clock of the rig
        assert rig.number < first + 1000
        rig.measure(10, hookload=math.nan, torque=math.nan)
    page = PageState(Sources())
    page.update(ESTIMATE_STATE, found[-1])
    shown = page.snapshot()["estimates"]
    assert (shown["level"], shown["rows"]) == (Level.ERROR, [])
    counted = f"not_finite {MEASURED_RIG_STATE}"  # on a busy machine it is told silent before it has taken all
    silent = bench.until_status(
        "estimator", lambda told: told.level == Level.STALE and int(told.values[counted]) == rig.number - first
    )
    assert silent.text.startswith(f"no good sample of {MEASURED_RIG_STATE} for ")
    rig.until_told(lambda status: (status.level, status.text) == (Level.OK, "the model explains what is measured"))


def test_a_channel_that_is_gone_is_told_while_the_others_correct(bench, estimator):
    rig = MeasuringRig(bench)
    status = rig.until_told(lambda status: status.level == Level.WARN, torque=math.nan)
    assert status.text.startswith(f"no good sample of torque of {MEASURED_RIG_STATE} for ")


def test_a_clock_that_stands_still_is_no_measurement(bench, estimator):
    rig = MeasuringRig(bench)
    rig.until_told(lambda status: status.text == "the model explains what is measured")
    rig.step = 0
    status = rig.until_told(lambda status: status.level in {Level.WARN, Level.ERROR})
    assert status.text.endswith("samples were late or repeated)")


@pytest.mark.fault("a rig falls silent", "estimates go on, doubtful and then unusable; they are good once it is back")
def test_estimates_go_on_while_a_rig_is_silent(bench, estimator):
    found, rig = bench.collect(ESTIMATE_STATE), MeasuringRig(bench)
    rig.until_told(lambda status: status.text == "the model explains what is measured")
    last = 0.02 * rig.number  # s
    bench.until(lambda: bool(found) and estimated(found[-1])["trust"] == Level.ERROR, what="an unusable estimate")
    bench.until_status("estimator", lambda status: status.level == Level.STALE)
    doubtful = [raw for raw in found if estimated(raw)["trust"] == Level.WARN]
    assert 10 <= len(doubtful) <= 16  # of windows of 0.2 s, up to 3 s
    stamps = [read_joint_state(raw).stamp * 1e-9 for raw in doubtful]
    assert np.diff(stamps) == pytest.approx(0.2)
    assert last - 0.4 < stamps[0] < last + 0.4
    rig.number = round(50 * read_joint_state(found[-1]).stamp * 1e-9) + 20  # its clock went on
    status = rig.until_told(lambda status: status.text == "the model explains what is measured")
    assert "samples_clock_jump" not in status.values
    told = estimated(found[-1])
    assert [told[name] for name in ("trust", "alarm", "unexplained")] == [0.0, 0.0, 0.0]


def test_a_rig_that_parts_from_the_model_is_a_warning(bench, estimator):
    found, rig = bench.collect(ESTIMATE_STATE), MeasuringRig(bench)
    rig.measure(400)
    words = "that none of the numbers explains: numbers are held"  # a busy machine may be too slow at first
    status = rig.until_told(lambda status: words in status.text, hookload=3000.0)
    assert status.level == Level.WARN
    last = estimated(found[-1])
    assert (last["trust"], last["alarm"]) == (Level.WARN, 1.0)


def made_up_map(file, scene):
    plane = Plane(Span(0.0, 80.0), Span(0.0, 8.0 * math.pi), 8)
    runs = {Key(i, j): RunRecord(Regime.SMOOTH) for i in range(9) for j in range(9)}
    found = OperatingMap(scene.name, digest_of(scene), scene.to_yaml(), plane, 10.0, (), runs)
    file.write_text(json.dumps(found.to_dict()), "utf-8")
    return str(file)


@pytest.mark.fault("simulator killed (-9)", "every node that reads it says since when it has no good sample")
def test_each_node_says_that_the_simulator_is_silent(bench):
    pytest.importorskip("asyncua")
    file = made_up_map(bench.folder / "map.json", load_scene("pa6_bench"))
    nodes = [
        bench.start("advisor", map=file),
        bench.start("analyzer"),
        bench.start("recorder", bag=str(bench.folder / "bag_0")),
        bench.start("gateway", port=free_port()),
        bench.start("estimator", "-r", f"measured/rig/state:={RIG_STATE[1:]}", members=4, show=False, horizon=0.0,
            overrides=COARSE,
        ),
    ]  # fmt: skip
    bench.until_ready("estimator", "recorder")
    simulator = bench.start("simulator")
    nodes.append(bench.start("rig_driver", wait_for="simulator"))
    names = ("advisor", "analyzer", "recorder", "gateway", "estimator", "rig_driver")
    for name in names:
        bench.until_status(name, lambda status: any(key.startswith("good_sample_age /") for key in status.values))
    simulator.kill()
    for name in names:
        status = bench.until_status(name, lambda status: "no good sample of /" in status.text)
        assert status.level == Level.STALE, status
    for node in nodes:
        assert node.end() == 0, node.text
        assert "Traceback" not in node.text


def test_each_node_says_that_its_input_has_never_come_unless_it_is_inactive(bench):
    pytest.importorskip("asyncua")
    asked = "is a simulator running in this namespace and domain?"
    told = {
        "advisor": f"no message on {TWIN_SCENE} for 6 s: {asked}",
        "analyzer": f"no message on {TWIN_SCENE} for 6 s: {asked}",
        "estimator": f"no message on {MEASURED_RIG_STATE} for 6 s: is a gateway running in this namespace and domain?",
        "gateway": "any of 9 topics for 6 s: is a twin running in this namespace and domain?",
        "recorder": "any of 14 topics for 6 s: is a twin running in this namespace and domain?",
        "rig_driver": f"no message on {CLOCK_TOPIC} for 6 s: {asked}",
        "watch": f"no message on {TWIN_SCENE} for 6 s: {asked}",
    }
    given = {"estimator": {"members": 4, "overrides": COARSE, "show": False}, "recorder": {"bag": "bag_0"},
        "gateway": {"port": free_port()}}  # fmt: skip
    nodes = [bench.start(name, **given.get(name, {})) for name in told if name != "watch"]
    nodes.append(bench.start_with(["--no-browser", "--port", "0"], "watch"))
    idle = bench.start("analyzer", "-r", "__node:=idle", autostart=False)
    bench.until(lambda: "waiting to be configured" in idle.text)
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE))
    assert bench.call("/idle/change_state", request, ChangeState).success
    for name, text in told.items():
        status = bench.until_status(name, lambda status: status.level == Level.WARN)
        assert re.sub(r" for \d+ s", " for 6 s", status.text).endswith(text), status
        assert name in {"recorder", "watch", "gateway"} or any(
            "waiting for" in one.text for one in bench.history if one.name == name
        )
    row = TOPICS[TWIN_SCENE]
    scenes = bench.node.create_publisher(message_class(row), TWIN_SCENE, quality(row))
    scenes.publish(encode_string(load_scene("pa6_bench").to_yaml()))
    rig = bench.publisher(RIG_STATE)  # has a publisher, which is silent
    for name, topic in (("advisor", RIG_STATE), ("analyzer", f"{MARKS_STATE} or {RIG_STATE}")):
        bench.until_status(name, lambda status, topic=topic: f"no message on {topic} for " in status.text)
    assert rig.get_subscription_count()
    assert {(one.level, one.values["state"]) for one in bench.history if one.name == "idle"} == {(Level.OK, "inactive")}
    for node in (*nodes, idle):
        assert node.end() == 0, node.text


def test_a_pause_is_no_fault_and_the_end_of_a_paused_simulator_is_one(bench):
    pytest.importorskip("asyncua")
    nodes = {
        "analyzer": bench.start("analyzer"),
        "recorder": bench.start("recorder", bag=str(bench.folder / "bag_0")),
        "gateway": bench.start("gateway", port=free_port(), use_sim_time=True),
        "estimator": bench.start("estimator", "-r", f"measured/rig/state:={RIG_STATE[1:]}", members=4, show=False,
            horizon=0.0, overrides=COARSE,
        ),
    }  # fmt: skip
    found = bench.collect(ESTIMATE_STATE)
    bench.until_ready("estimator", "recorder")
    simulator = bench.start("simulator")
    nodes["rig_driver"] = bench.start("rig_driver", wait_for="simulator")
    for name in nodes:
        bench.until_status(name, lambda status: any(key.startswith("good_sample_age /") for key in status.values))
    bench.until(lambda: bool(found), what="an estimate")
    assert bench.call("/simulator/pause").success
    bench.until_status("simulator", lambda status: status.values["state"] == "paused")
    for name in nodes:
        bench.until_status(name, lambda status: status.level != Level.STALE)
    begun, estimates = len(bench.history), len(found)
    for _ in range(7):
        bench.until_status("simulator", bool)
    later = bench.history[begun:]
    assert {one.name for one in later} == {*nodes, "simulator"}
    assert not [one for one in later if one.level == Level.STALE or "no good sample" in one.text]
    assert not [one for one in later if one.level != Level.OK and one.name != "estimator"]  # it may tell of the motion
    assert len(found) <= estimates + 1  # the ensemble waits for a rig whose time stands still
    assert bench.call("/simulator/resume").success
    bench.until(lambda: len(found) > estimates + 2, what="estimates to go on")
    assert "samples_clock_jump" not in bench.until_status("estimator", bool).values
    assert bench.call("/simulator/pause").success
    simulator.kill()
    for name in nodes:
        bench.until_status(name, lambda status: status.level == Level.STALE)
    for node in nodes.values():
        assert node.end() == 0, node.text
        assert "Traceback" not in node.text


def test_a_replay_that_rests_is_no_fault(bench, small_bag):
    analyzer = bench.start("analyzer")
    replayer = bench.start("replayer", bag=str(small_bag), rate=0.02)
    bench.until_status("analyzer", lambda status: status.text.startswith("motion: "))
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_DEACTIVATE))
    assert bench.call("/replayer/change_state", request, ChangeState).success
    assert bench.call("/replayer/pause").message.startswith("inactive; once the node is active: paused at ")
    bench.until_status("analyzer", lambda status: status.level == Level.OK)
    begun = len(bench.history)
    for _ in range(6):
        bench.until_status("replayer", lambda status: status.values["state"] == "inactive")
    assert {one.level for one in bench.history[begun:] if one.name == "analyzer"} == {Level.OK}
    for node in (analyzer, replayer):
        assert node.end() == 0, node.text


@pytest.mark.fault("NaN on /rig/state and /marks/state", "counted and told; no advice, nothing shown as good")
def test_samples_without_a_finite_number_are_counted_and_told(bench):
    pytest.importorskip("asyncua")
    scene = load_scene("pa6_bench")
    nodes = [bench.start("advisor"), bench.start("gateway", port=free_port())]
    nodes.append(bench.start("analyzer", marks_scene="pa6_bench"))
    rig, marks = bench.publisher(RIG_STATE), bench.publisher(MARKS_STATE)
    bench.until(lambda: rig.get_subscription_count() == 3, what="three readers")
    joints = [f"{mark.name}/{axis}" for mark in scene.string.marks for axis in MARK_AXES]
    of_rig, of_marks = JointStateTemplate(RIG_JOINTS), JointStateTemplate(joints)
    for number in range(1, 5000):
        for publisher, template, names in ((rig, of_rig, RIG_JOINTS), (marks, of_marks, joints)):
            publisher.publish(bytes(template.fill(10_000_000 * number, *[[math.nan] * len(names)] * 3)))
        bench.spin(0.01)
        told = [bench.statuses.get(name) for name in ("advisor", "gateway", "analyzer")]
        if all(status is not None and status.level == Level.ERROR for status in told):
            break
    for status in told:
        assert status.text.startswith("no good sample of /"), status
        assert "samples had no finite number" in status.text
    assert int(told[0].values[f"not_finite {RIG_STATE}"]) > 100
    assert int(told[2].values[f"not_finite {MARKS_STATE}"]) > 100
    for node in nodes:
        assert node.end() == 0, node.text
        assert "Traceback" not in node.text
