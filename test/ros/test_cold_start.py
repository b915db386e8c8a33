# SPDX-License-Identifier: Apache-2.0
"""Nodes that start with an empty cache of kernels: progress, services that answer, drivers that wait, signals."""

import signal
import sys
from pathlib import Path

import pytest
from lifecycle_msgs.srv import GetState

from drill_twin.ros.core.startup_barrier import COMPILING


def _compiles(status):
    return status.values.get("compiling", "").startswith(COMPILING) and " functions, " in status.text


@pytest.fixture
def cold(bench, tmp_path):
    bench.environment["DRILL_TWIN_CACHE"] = str(tmp_path / "cache")
    return bench


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)])
def test_it_reports_answers_and_ends_on_a_signal(cold, number):
    simulator = cold.start("simulator")
    cold.until_status("simulator", _compiles)
    assert f"[simulator]: {COMPILING}" in simulator.text
    assert cold.call("/simulator/get_state", None, GetState).current_state.label == "configuring"
    answer = cold.call("/simulator/ready")
    assert not answer.success
    assert answer.message.startswith(COMPILING)
    workers = _workers(simulator.pid)
    assert workers
    assert simulator.end(number) == 0
    assert "Traceback" not in simulator.text
    assert not any(_is_running(worker) for worker in workers)


def test_the_estimator_does_not_wait_for_the_compilation_to_end(cold):
    estimator = cold.start("estimator", free="load_factor=0.8..1.2", members=4)
    cold.until_status("estimator", lambda status: " functions, " in status.text)
    workers = _workers(estimator.pid)
    assert workers
    assert estimator.end(signal.SIGTERM) == 0, estimator.text
    assert "Traceback" not in estimator.text
    assert not any(_is_running(worker) for worker in workers)


def test_a_transition_that_compiles_ends_on_a_signal(cold):
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState

    simulator = cold.start("simulator", autostart=False)
    client = cold.node.create_client(ChangeState, "/simulator/change_state")
    cold.until(client.service_is_ready)
    client.call_async(ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE)))
    cold.until_status("simulator", _compiles)
    assert simulator.end() == 0


def test_a_killed_simulator_leaves_no_child(cold):
    simulator = cold.start("simulator")
    cold.until_status("simulator", _compiles)
    (worker,) = _workers(simulator.pid)
    simulator.kill()
    cold.until(lambda: not _is_running(worker), what="the child to end")


def test_the_command_line_reports_and_ends_on_a_signal(cold, tmp_path):
    words = [sys.executable, "-m", "drill_twin.cli", "run", "pa6_bench", "--out", str(tmp_path / "run")]
    command = cold.command("run", words)
    cold.until(lambda: COMPILING in command.text)
    assert command.end() == 130
    assert "Traceback" not in command.text


@pytest.mark.long
def test_a_driver_waits_as_long_as_the_simulator_compiles(cold):
    simulator = cold.start("simulator", duration=0.5, pace="fast")
    cold.until_status("simulator", _compiles)
    driver = cold.start("rig_driver", wait_timeout=3.0)
    cold.until(lambda: simulator.code is not None or driver.code is not None, 600.0, "the run to end")
    assert simulator.code == 0, cold.logs()
    assert driver.end() == 0, cold.logs()
    assert f"waiting for /simulator: {COMPILING}" in driver.text


def _workers(parent):
    threads = Path(f"/proc/{parent}/task").glob("*/children")
    return [int(word) for children in threads for word in children.read_text("utf-8").split()]


def _is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
