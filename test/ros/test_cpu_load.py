# SPDX-License-Identifier: Apache-2.0
"""Processor load of running nodes, measured from `/proc`."""

import json
import os
import signal
import sys
import time
from pathlib import Path

import pytest

from drill_twin_evidence.benchmarks.cpu_load import processor_time

COMMAND = ["env", "-u", "ROS_DOMAIN_ID", sys.executable, "-m", "drill_twin_evidence.benchmarks.cpu_load"]


def test_processor_time_is_that_of_the_process():
    before, own = processor_time(os.getpid()), time.process_time()
    while time.process_time() - own < 0.3:
        pass
    assert processor_time(os.getpid()) - before == pytest.approx(time.process_time() - own, abs=0.05)


def test_ctrl_c_leaves_no_node(bench):
    process = bench.command("load", COMMAND)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    bench.until(lambda: len(children.read_text("utf-8").split()) == 4, what="the nodes")
    nodes = children.read_text("utf-8").split()
    assert process.end(signal.SIGINT) not in {0, None}, process.text
    assert "Traceback" not in process.text
    bench.until(lambda: not any(Path(f"/proc/{node}").exists() for node in nodes), 20.0, "the end of the nodes")


@pytest.mark.long
def test_every_node_is_measured_while_it_works(bench):
    words = ["--duration", "3", "--elements", "16", "--rate", "100", "--json"]
    process = bench.command(
        "load", ["env", "-u", "ROS_DOMAIN_ID", sys.executable, "-m", "drill_twin_evidence.benchmarks.cpu_load", *words]
    )
    assert process.wait(120.0) == 0, process.text
    told = json.loads(process.text[process.text.index("{") :])
    shares = {row["node"]: row for row in told["nodes"]}
    assert set(shares) == {"simulator", "rig_driver", "analyzer", "recorder"}
    assert all(row["processor"] > 0.0 and row["memory"] > 2**24 for row in shares.values())
    assert int(told["simulator"]["frames"]) > 200
    assert told["simulator"]["elements"] == "16"
