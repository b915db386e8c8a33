# SPDX-License-Identifier: Apache-2.0
"""The simulator under a lifecycle manager: each transition does what it says, and a bad scene leaves it as it was."""

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState

from drill_twin.io.messages.topics import CLOCK_TOPIC, STRING_POSES


def _set(bench, transition):
    request = ChangeState.Request(transition=Transition(id=transition))
    return bench.call("/simulator/change_state", request, ChangeState).success


def _state(bench):
    return bench.call("/simulator/get_state", None, GetState).current_state.label


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


def test_a_scene_that_cannot_be_built_leaves_it_unconfigured(bench):
    process = bench.start("simulator", autostart=False, scene="no_such_scene")
    bench.until(lambda: "waiting to be configured" in process.text)
    assert not _set(bench, Transition.TRANSITION_CONFIGURE)
    assert _state(bench) == "unconfigured"
    bench.until(lambda: "no_such_scene" in process.text)
    assert process.end() == 0
