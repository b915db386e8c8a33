# SPDX-License-Identifier: Apache-2.0
"""Nodes under a lifecycle manager: each transition does what it says, and a node that refuses stays as it was."""

import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState

from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, RIG_COMMAND, STRING_POSES
from drill_twin.ros.entry_points import node_names


def _set(bench, transition, node="simulator"):
    request = ChangeState.Request(transition=Transition(id=transition))
    return bench.call(f"/{node}/change_state", request, ChangeState).success


def _state(bench, node="simulator"):
    return bench.call(f"/{node}/get_state", None, GetState).current_state.label


def _publishes(bench, node):
    names = {name for name, _ in bench.node.get_publisher_names_and_types_by_node(node, "/")}
    return names - {DIAGNOSTICS, "/parameter_events", "/rosout", f"/{node}/transition_event"}


def test_a_manager_configures_activates_deactivates_cleans_up_and_ends_it(bench):
    clocks = bench.collect(CLOCK_TOPIC)
    process = bench.start("simulator", autostart=False, wait_for_command=False)
    bench.until(lambda: "waiting to be configured" in process.text)
    assert _state(bench) == "unconfigured"
    assert bench.node.count_publishers(STRING_POSES) == 0
    assert not _set(bench, Transition.TRANSITION_ACTIVATE)
    assert _set(bench, Transition.TRANSITION_CONFIGURE)
    assert _state(bench) == "inactive"
    bench.until(lambda: bench.node.count_publishers(STRING_POSES) == 1)
    assert bench.until_status("simulator", lambda status: "inactive at" in status.text).values["frames"] == "0"
    assert _set(bench, Transition.TRANSITION_ACTIVATE)
    bench.until_ready("simulator")
    bench.until(lambda: len(clocks) > 20, what="time to run")
    assert _set(bench, Transition.TRANSITION_DEACTIVATE)
    bench.drain()
    still = len(clocks)
    bench.spin(0.3)
    assert len(clocks) == still
    assert _set(bench, Transition.TRANSITION_CLEANUP)
    bench.until(lambda: bench.node.count_publishers(STRING_POSES) == 0, what="its topics to go")
    assert _set(bench, Transition.TRANSITION_CONFIGURE)
    assert _set(bench, Transition.TRANSITION_ACTIVATE)
    bench.until(lambda: len(clocks) > still + 20, what="a second run")
    assert _set(bench, Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert process.wait() == 0, process.text
    assert "Traceback" not in process.text


def test_a_driver_at_rest_commands_nothing_although_the_clock_goes_on(bench):
    commands = bench.collect(RIG_COMMAND)
    bench.start("simulator")
    bench.start("rig_driver")
    bench.until(lambda: len(commands) > 20, what="set-points")
    assert _set(bench, Transition.TRANSITION_DEACTIVATE, "rig_driver")
    clocks = bench.collect(CLOCK_TOPIC)
    bench.until(lambda: len(clocks) > 20, what="time to run on, with the last set-point")
    still = len(commands)
    bench.until(lambda: len(clocks) > 120, what="a second of the run")
    assert len(commands) == still
    assert _set(bench, Transition.TRANSITION_ACTIVATE, "rig_driver")
    bench.until(lambda: len(commands) > still + 20, what="set-points again")


def test_a_scene_that_cannot_be_built_leaves_it_unconfigured(bench):
    process = bench.start("simulator", autostart=False, scene="no_such_scene")
    bench.until(lambda: "waiting to be configured" in process.text)
    assert not _set(bench, Transition.TRANSITION_CONFIGURE)
    assert _state(bench) == "unconfigured"
    bench.until(lambda: "no_such_scene" in process.text)
    assert process.end() == 0


@pytest.mark.parametrize("node", [node for node in node_names() if node != "simulator"])
def test_every_node_is_configured_activated_rests_is_cleaned_up_and_configured_again(bench, small_bag, node):
    given = {
        "recorder": {"bag": ""},
        "replayer": {"bag": str(small_bag), "rate": 0.01},
        "estimator": {"members": 4},
        "rig_driver": {"at_end": "stop"},
    }
    process = bench.start(node, autostart=False, **given.get(node, {}))
    bench.until(lambda: "waiting to be configured" in process.text)
    bench.until(lambda: node in bench.node.get_node_names(), what="its name")
    assert not _publishes(bench, node)
    for begun in (1, 2):
        assert _set(bench, Transition.TRANSITION_CONFIGURE, node), process.text
        assert _state(bench, node) == "inactive"
        answer = bench.call(f"/{node}/ready")
        assert not answer.success
        assert answer.message
        assert _set(bench, Transition.TRANSITION_ACTIVATE, node)
        assert _set(bench, Transition.TRANSITION_DEACTIVATE, node)
        if begun == 1:
            assert _set(bench, Transition.TRANSITION_CLEANUP, node)
            assert not _set(bench, Transition.TRANSITION_ACTIVATE, node)
            bench.until(lambda: not _publishes(bench, node), what="its topics to go")
    assert _set(bench, Transition.TRANSITION_INACTIVE_SHUTDOWN, node)
    assert process.wait() == 0, process.text
    assert "Traceback" not in process.text
