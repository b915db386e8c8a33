# SPDX-License-Identifier: Apache-2.0
"""Every node starts, and ends on SIGINT and SIGTERM with exit code 0 and no traceback, whenever the signal comes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from std_msgs.msg import Float64
from variants import long_one_of

from drill_twin.io.messages.topics import WOB_COMMAND
from drill_twin.ros.core.stop_request import END_WITH_PARENT
from drill_twin.ros.entry_points import node_names

EXECUTABLES = (*node_names(), "twin")
SIGNALS = (signal.SIGINT, signal.SIGTERM)


@pytest.fixture
def bench(bench):
    """Each process begins with the start of Python."""
    bench.warm = False
    return bench


def _ends():
    """Each executable with one of the signals, in turn; with the other one it is long."""
    for number, node in enumerate(EXECUTABLES):
        for which, asked in enumerate(SIGNALS):
            marks = [pytest.mark.long] if (number + which) % 2 else []
            yield pytest.param(node, asked, id=f"{node}-{asked.name}", marks=marks)


def _parameters(node, bench, small_bag):
    return {
        "rig_driver": {"wait_for": ""},
        "recorder": {"bag": str(bench.folder / "bag_0")},
        "replayer": {"bag": str(small_bag), "rate": 0.001},
        "twin": {"record": True, "bag": str(bench.folder / "bag_0")},
    }.get(node, {})


@pytest.mark.parametrize(("node", "number"), list(_ends()))
def test_a_running_node_ends_when_asked(bench, small_bag, node, number):
    process = bench.start(node, **_parameters(node, bench, small_bag))
    bench.until(lambda: (process.code is not None) or bool(bench.statuses), what=f"diagnostics of {node}")
    assert process.code is None, process.text
    assert process.end(number) == 0, process.text
    assert "Traceback" not in process.text
    assert "rror" not in process.text


@pytest.mark.parametrize("number", [SIGNALS[0], pytest.param(SIGNALS[1], marks=pytest.mark.long)])
def test_a_simulator_in_an_endless_frame_ends_when_asked(bench, number):
    """Ten million steps a frame: compiled code returns to Python in between."""
    scene = bench.folder / "endless.yaml"
    scene.write_text("base: pa6_bench\nname: endless\nnumerics: {step: 1 ns}\n", "utf-8")
    process = bench.start("simulator", scene=str(scene))
    bench.until(lambda: (process.code is not None) or "ns steps" in process.text or "us steps" in process.text,
                what="the simulator's configuration")  # fmt: skip
    time.sleep(1.0)  # within the first frame
    assert process.end(number) == 0, process.text
    assert "Traceback" not in process.text


def test_a_signal_in_the_middle_of_an_import_waits_for_its_end(bench):
    """An exception there would be swallowed, or leave the lock of all imports locked: no thread could end any more."""
    (bench.folder / "slow_module.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGTERM)\ntime.sleep(0.3)\nwhole = True\n", "utf-8"
    )
    process = bench.command(
        "stopped",
        [
            sys.executable,
            "-c",
            (
                "import sys, time; from drill_twin.ros.core.stop_request import Stopped, StopRequest\n"
                f"sys.path.insert(0, {str(bench.folder)!r}); stop = StopRequest(); stop.install()\n"
                "try:\n"
                "    with stop.at_once(): import slow_module; time.sleep(30.0)\n"
                "except Stopped: print('stopped', slow_module.whole, bool(stop))"
            ),
        ],
    )
    assert process.wait() == 0, process.text
    assert process.text == "stopped True True\n"


@pytest.mark.parametrize("delay", [0.4, *(pytest.param(delay, marks=pytest.mark.long) for delay in (0.05, 1.0, 2.0))])
def test_a_signal_during_the_start_ends_it_too(bench, delay):
    process = bench.start("twin")
    # Before Python itself has started the default action of the signal holds, in any program.
    bench.until(lambda: "numpy" in _maps(process.pid) or process.code is not None, what="the interpreter to start")
    time.sleep(delay)
    assert process.end(signal.SIGTERM) == 0, process.text
    assert "Traceback" not in process.text


_DELAYS = np.random.default_rng(28).uniform(0.0, 4.0, 20)


@pytest.mark.parametrize("delay", long_one_of(4, _DELAYS, short=1))
def test_two_signals_at_once_end_a_node_at_any_moment_of_its_start(bench, delay):
    """As `timeout` sends them to a launch and its group."""
    process = bench.start("analyzer")
    bench.until(lambda: "numpy" in _maps(process.pid) or process.code is not None, what="the interpreter to start")
    time.sleep(delay)
    for number in (signal.SIGTERM, signal.SIGINT):
        process.send(number)
    assert process.wait(60.0) == 0, process.text
    assert "Traceback" not in process.text


def test_stopped_comes_again_where_it_was_swallowed(bench):
    words = (
        "import time; from drill_twin.ros.core import stop_request; stop_request._REPEAT = 0.05\n"
        "stop = stop_request.StopRequest(); stop.install(); swallowed = 0\n"
        "try:\n"
        "    with stop.at_once():\n"
        "        print('begun', flush=True)\n"
        "        while True:\n"
        "            try: time.sleep(30.0)\n"
        "            except BaseException:\n"
        "                swallowed += 1\n"
        "                if swallowed == 3: raise\n"
        "except stop_request.Stopped: print(swallowed)"
    )
    process = bench.command("stubborn", [sys.executable, "-c", words])
    bench.until(lambda: "begun" in process.text)
    assert process.end(signal.SIGTERM) == 0, process.text
    assert process.text == "begun\n3\n"


@pytest.mark.parametrize("held", [False, True])
def test_a_loop_that_does_not_look_is_ended_a_second_after_the_signal(bench, held):
    """Unless it does what must be completed."""
    words = (
        "import time; from drill_twin.ros.core import stop_request; stop_request._PATIENCE = 0.05\n"
        f"stop = stop_request.StopRequest(); stop.install(); stop.held = {held}; whole = False\n"
        "try:\n"
        "    with stop.soon():\n"
        "        print('begun', flush=True)\n"
        "        while not stop: pass\n"
        "        end = time.monotonic() + 0.5\n"
        "        while time.monotonic() < end: pass\n"
        "        whole = True; stop.held = False\n"
        "        while True: pass\n"
        "except stop_request.Stopped: print(whole)"
    )
    process = bench.command("busy", [sys.executable, "-c", words])
    bench.until(lambda: "begun" in process.text)
    assert process.end(signal.SIGTERM) == 0, process.text
    assert process.text == f"begun\n{held}\n"


def test_a_node_ends_with_the_launch_that_is_killed(bench):
    """Nobody is left then to ask it; what is started by hand stays."""
    words = "import subprocess, sys; subprocess.Popen(sys.argv[1:]); sys.stdin.read(); import time; time.sleep(600)"
    node = [sys.executable, "-m", "drill_twin.ros", "analyzer", "--ros-args", "-r"]
    bound = bench.command("bound", [sys.executable, "-c", words, *node, "__node:=bound"], **{END_WITH_PARENT: "1"})
    free = bench.command("free", [sys.executable, "-c", words, *node, "__node:=free"])
    pids = {}
    for name, launch in (("bound", bound), ("free", free)):
        bench.until_status(name, bool)
        (pids[name],) = Path(f"/proc/{launch.pid}/task/{launch.pid}/children").read_text("utf-8").split()
        launch.kill()
    bench.until(lambda: not Path(f"/proc/{pids['bound']}").exists(), what="the node to end with its launch")
    assert Path(f"/proc/{pids['free']}").exists()
    os.kill(int(pids["free"]), signal.SIGTERM)
    bench.until(lambda: not Path(f"/proc/{pids['free']}").exists(), what="the other to end when asked")


def test_a_node_ends_whose_launch_is_gone_before_it_can_watch(bench):
    """As of a launch that is killed while its nodes begin."""
    with subprocess.Popen([sys.executable, "-c", ""]) as gone:
        pass
    node = bench.command(
        "late", [sys.executable, "-m", "drill_twin.ros", "analyzer"], **{END_WITH_PARENT: str(gone.pid)}
    )
    assert node.wait(60.0) == 0, node.text


@pytest.mark.parametrize("node", ["rig_driver", pytest.param("analyzer", marks=pytest.mark.long)])
def test_signals_after_the_first_do_not_change_the_exit_code(bench, small_bag, node):
    """As in a launch, whose terminal sends a SIGINT beside that of the launch itself."""
    process = bench.start(node, **_parameters(node, bench, small_bag))
    bench.until_status(node, bool)
    while process.code is None:
        process.send(signal.SIGINT)
        time.sleep(0.001)
    assert process.code == 0, process.text
    assert "Traceback" not in process.text


def test_the_simulator_ends_by_itself_after_its_duration(bench):
    clock = bench.collect("/clock", latched=True)
    process = bench.start("simulator", pace="fast", duration=0.5)
    bench.until_ready("simulator")
    bench.publisher(WOB_COMMAND).publish(Float64(data=10.0))
    bench.until(lambda: process.code is not None, what="the simulator to end")
    assert process.code == 0, process.text
    bench.drain()
    assert len(clock) == 51  # the start, and 50 frames at 100 Hz


def test_a_node_in_a_namespace_keeps_its_topics_there(bench):
    process = bench.start("simulator", "-r", "__ns:=/left", wait_for_command=False)
    bench.until(lambda: bench.node.count_publishers("/left/string/poses") == 1, what="/left/string/poses")
    bench.until(lambda: "left/simulator" in bench.statuses, what="diagnostics under the full name")
    assert bench.node.count_publishers("/string/poses") == 0
    assert bench.node.count_publishers("/diagnostics") == 1
    assert process.end() == 0


def _maps(pid):
    try:
        return Path(f"/proc/{pid}/maps").read_text("utf-8")
    except OSError:
        return ""
