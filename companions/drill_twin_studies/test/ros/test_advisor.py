# SPDX-License-Identifier: Apache-2.0
"""The advisor node: a map of the scene, of another one, or made by itself; in closed loop with a real driver."""

import json
import math

import pytest

from drill_twin.io.messages.decode import read_joint_state, read_string
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.topic_words import AdviceCode, digest_of
from drill_twin.io.messages.topics import ADVICE_MAP, ADVICE_STATE
from drill_twin.scene import load_scene
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span
from drill_twin_studies.maps.runs import Key, RunRecord

COARSE = (
    "numerics.elements=8; numerics.step=10 ms; numerics.frame_rate=50 Hz; rig.rotation.duration=1 s; "
    "rig.weight_on_bit.duration=1 s; rig.duration=10 s"
)
"""Kernel of the paper's rod; each run of the map lasts 10 s."""


def made_up_map(file, scene):
    """Calm below 20 N, whatever the speed."""
    plane = Plane(Span(0.0, 80.0), Span(0.0, 8.0 * math.pi), 8)
    runs = {
        Key(i, j): RunRecord(Regime.FORWARD if i >= 2 else Regime.SMOOTH) for i in range(9) for j in range(9)
    }  # fmt: skip
    found = OperatingMap(scene.name, digest_of(scene), scene.to_yaml(), plane, 10.0, (), runs)
    file.write_text(json.dumps(found.to_dict()), "utf-8")
    return str(file)


def advice_of(raw):
    """Values of a message by name."""
    state = read_joint_state(raw)
    return dict(zip(state.names, state.position.tolist(), strict=True))


def test_it_advises_from_a_map_and_commands_nothing(bench):
    file = made_up_map(bench.folder / "map.json", load_scene("pa6_bench"))
    states, maps = bench.collect(ADVICE_STATE), bench.collect(ADVICE_MAP, latched=True)
    advisor = bench.start("advisor", map=file)
    bench.until(lambda: ADVICE_STATE in dict(bench.node.get_topic_names_and_types()), what="the advisor")
    over = "rig.weight_on_bit.duration=1 s; rig.rotation.duration=1 s"
    simulator = bench.start("simulator", duration=7.0, overrides=over)
    driver = bench.start("rig_driver", wait_for="simulator test", overrides=over)
    bench.until(lambda: simulator.code is not None, what="the run to end")
    for process in (advisor, driver):
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text
    said = [advice_of(raw) for raw in states]
    assert said[-1]["advice"] == AdviceCode.LEAVE
    assert said[-1]["target/weight_on_bit"] <= 10.0
    sentences = [status for status in bench.history if status.name == "advisor" and "go to" in status.text]
    assert "the nearest calm set-point" in sentences[-1].text
    assert sentences[-1].level == Level.WARN
    settled = next(number for number, one in enumerate(said) if one["advice"] == AdviceCode.LEAVE)
    assert not any(one["target"] for one in said[:settled])
    targets = {(one["target/weight_on_bit"], one["target/rotation"]) for one in said[settled:]}
    assert len(targets) <= 2  # before and after the onset of whirl
    assert json.loads(read_string(maps[-1]))["scene_name"] == "pa6_bench"
    assert not [name for name, _ in bench.node.get_publisher_names_and_types_by_node("test", "/") if "rig" in name]


def test_a_map_of_another_scene_is_told_in_a_sentence(bench):
    other = load_scene("pa6_bench", overrides={"hole.radius": "80 mm"})
    file = made_up_map(bench.folder / "map.json", other)
    states = bench.collect(ADVICE_STATE)
    advisor = bench.start("advisor", map=file)
    simulator = bench.start("simulator")
    said = bench.until_status("advisor", lambda status: status.level == Level.ERROR)
    assert "expected a map of pa6_bench, found a map of pa6_bench with other numbers" in said.text
    assert "\n" not in said.text
    bench.until(lambda: states, what="advice")
    assert advice_of(states[-1])["advice"] == AdviceCode.NONE
    for process in (advisor, simulator):
        assert process.end() == 0, process.text


def test_a_file_that_is_no_map_is_refused(bench):
    file = bench.folder / "map.json"
    file.write_text("{}", "utf-8")
    advisor = bench.start("advisor", map=str(file))
    assert advisor.wait() == 2, advisor.text
    assert "expected the map.json of `drill-twin map`" in advisor.text
    assert "Traceback" not in advisor.text


def test_without_a_map_it_says_at_once_how_far_it_is(bench):
    states = bench.collect(ADVICE_STATE)
    advisor = bench.start("advisor")
    simulator = bench.start("simulator")
    told = "making a coarse map, 0 of at most 100 runs (0%) made"
    assert bench.until_status("advisor", lambda status: told in status.text).level == Level.OK
    bench.until(lambda: len(states) >= 2, what="advice")
    assert [advice_of(raw)["advice"] for raw in states[:2]] == [AdviceCode.NONE] * 2
    for process in (advisor, simulator):
        assert process.end() == 0, process.text


@pytest.mark.long
@pytest.mark.parametrize(
    ("weights", "speeds", "calm"), [("1..60 N", "0.1..3 rev/s", True), ("40..60 N", "1.5..3 rev/s", False)]
)
def test_a_driver_that_follows_the_advice_leaves_whirl_or_is_told_that_it_cannot(bench, weights, speeds, calm):
    """The advisor makes a map of its own while the string whirls; the driver's plan is set as a person would."""
    states, followed = bench.collect(ADVICE_STATE), []
    advisor = bench.start("advisor", wob_range=weights, rpm_range=speeds, workers=2)
    analyzer = bench.start("analyzer")
    simulator = bench.start("simulator", overrides=COARSE)
    bench.start("rig_driver", wait_for="simulator analyzer test", overrides=COARSE, change_time=2.5)
    advised = lambda: advice_of(states[-1]) if states else {"advice": 0.0, "whirls": 0.0}  # noqa: E731
    bench.until(lambda: advised()["advice"] and advised()["whirls"], 300.0, "a map and a whirl")
    if not calm:
        bench.until_status("advisor", lambda status: "no calm set-point in its ranges" in status.text)
    else:

        def out_of_whirl():
            said = advised()
            if said["target"]:
                wanted = said["target/weight_on_bit"], said["target/rotation"] / math.tau
                if [wanted] != followed[-1:]:
                    followed.append(wanted)
                    assert bench.set_parameter("rig_driver", "wob", f"{wanted[0]!r} N").successful
                    assert bench.set_parameter("rig_driver", "rpm", f"{wanted[1]!r} rev/s").successful
            return said["advice"] == AdviceCode.HOLD and not said["whirls"]

        bench.until(out_of_whirl, 120.0, "the end of the whirl")
        assert followed
    for process in (analyzer, advisor, simulator):
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text
