# SPDX-License-Identifier: Apache-2.0
"""Health of the nodes that consume data: what they say when nothing, or nothing good, is measured any more."""

import json
import math

import numpy as np
import pytest
from ports import free_port

from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.encode import MARK_AXES
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.io.messages.topics import ESTIMATE_STATE, MARKS_STATE, MEASURED_RIG_STATE, RIG_STATE
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
        members=4,
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
    silent = bench.until_status("estimator", lambda status: status.level == Level.STALE)
    assert silent.text.startswith(f"no good sample of {MEASURED_RIG_STATE} for ")
    assert int(silent.values[f"not_finite {MEASURED_RIG_STATE}"]) == rig.number - first
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


def test_a_rig_that_parts_from_the_model_is_a_warning(bench, estimator):
    found, rig = bench.collect(ESTIMATE_STATE), MeasuringRig(bench)
    rig.measure(400)
    status = rig.until_told(lambda status: status.level != Level.OK, hookload=3000.0)
    assert status.level == Level.WARN
    assert "that none of the numbers explains: they are held as they were" in status.text
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
