# SPDX-License-Identifier: Apache-2.0
"""Servers of a rig, processes of asyncua, open62541 and node-opcua: signals as /measured, set-points as commands."""

import json
import math
import os
import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from ports import free_port

asyncua = pytest.importorskip("asyncua", reason="needs asyncua: pip install 'drill_twin[opcua]'")

from drill_twin.core.errors import ParameterError  # noqa: E402
from drill_twin.dynamics.sensors.subs import SUMMARY  # noqa: E402
from drill_twin.io.messages.diagnostics import Level  # noqa: E402
from drill_twin.io.messages.sensor_messages import read_summary  # noqa: E402
from drill_twin.io.messages.topics import MEASURED, MEASURED_RIG_STATE, RIG_COMMAND, RIG_STATE, summary_topic  # noqa: E402
from drill_twin_rig.gateway.opc_ua.keys import CERTIFICATE, TRUSTED, make_keys  # noqa: E402
from drill_twin_rig.ros.rig import check_security  # noqa: E402

HERE = Path(__file__).resolve().parent / "clients"
SIGNALS = """
measure:
  weight_on_bit:    {node: "nsu=urn:rig;s=WOB", unit: kN, high: 100, frozen_after: 0}
  hookload:         {node: "nsu=urn:rig;s=Hook", unit: kN, frozen_after: 1.5}
  surface_rotation: {node: "nsu=urn:rig;s=RPM", unit: rpm}
  surface_torque:   {node: "nsu=urn:rig;s=Wrong", unit: N m}
  near_bit.speed_mean: {node: "nsu=urn:rig;s=RPM", unit: rpm}
"""
FOLLOW = """
follow:
  weight_on_bit:    {node: "nsu=urn:rig;s=WOBSet", unit: N, stale_after: 1}
  surface_rotation: {node: "nsu=urn:rig;s=RPMSet", unit: rpm, stale_after: 1}
"""


class Server:
    """Server of a rig as a process that is told what to do."""

    def __init__(self, *command, **environment):
        self._process = subprocess.Popen(
            [*map(str, command)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True, env={**os.environ, **environment},
        )  # fmt: skip
        while json.dumps("serving") not in (line := self._process.stdout.readline()):
            assert line, "the server ended"

    def ask(self, *words):
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def kill(self):
        self._process.kill()
        self._process.wait()


@pytest.fixture
def serve():
    servers = []

    def start(*command, **environment):
        servers.append(Server(*command, **environment))
        return servers[-1]

    yield start
    for server in servers:
        server.kill()


def _gateway(bench, port, text, **given):
    file = bench.folder / "signals.yaml"
    file.write_text(text, "utf-8")
    given = {"rig_security": "none", **given}
    return bench.start(
        "gateway", signals=str(file), port=free_port(), rig_url=f"opc.tcp://127.0.0.1:{port}/rig", **given
    )


def _fault(bench, text, seconds=60.0):
    return bench.until_status("gateway", lambda status: text in status.text, seconds)


def test_a_rig_is_measured_its_faults_are_told_and_it_is_found_again(bench, serve, joints):
    port, messages = free_port(), bench.collect(MEASURED_RIG_STATE)
    summaries = bench.collect(MEASURED + summary_topic("near_bit"))
    rig = serve(sys.executable, HERE / "asyncua_rig.py", port)
    _gateway(bench, port, SIGNALS)
    bench.until(lambda: messages and summaries, what="a measured state, and a summary of the tool")
    sent_up = dict(zip(SUMMARY, read_summary(joints(summaries[-1:])[0]), strict=True))
    assert sent_up["speed_mean"] == pytest.approx(math.tau / 6.0)
    assert np.isnan(sent_up["axial_rms"])
    state = joints(messages[-1:])[0]
    assert state.effort[state.index("bit_axial")] == 10e3
    assert state.velocity[state.index("top_drive")] == pytest.approx(math.tau / 6.0)
    unit = "wrong unit: expected N m, found lbf on the server"
    bench.until_status("gateway", lambda one: one.values["measured_surface_torque"] == unit)
    assert any(unit in one.text or "frozen" in one.text for one in bench.history)  # the text is the first fault
    assert np.isnan(state.effort[state.index("top_drive")])

    bench.until_status("gateway", lambda one: one.values["measured_hookload"] == "frozen for more than 1.5 s")
    for value, fault in ((math.nan, "expected a finite number, found nan"), (101.0, "expected -inf to 100 kN")):
        rig.ask("set", "WOB", value)
        bench.until_status("gateway", lambda one, fault=fault: fault in one.values["measured_weight_on_bit"])
        last = joints(messages[-1:])[0]
        assert np.isnan(last.effort[last.index("bit_axial")])
    rig.ask("set", "WOB", 20.0)
    rig.ask("stamp", -60.0)
    bench.until_status("gateway", lambda one: one.values["measured_weight_on_bit"] == "stale stamp")
    assert all(one.effort[one.index("bit_axial")] in {10e3, 20e3} for one in joints(messages) if _known(one))

    rig.kill()
    _fault(bench, "no connection to the rig")
    count = len(messages)
    bench.spin(0.5)
    assert len(messages) == count
    rig = serve(sys.executable, HERE / "asyncua_rig.py", port)
    rig.ask("set", "WOB", 30.0)
    bench.until(lambda: len(messages) > count and _known(joints(messages[-1:])[0]), what="the rig, found again")
    last = joints(messages[-1:])[0]
    assert last.effort[last.index("bit_axial")] == 30e3


def _known(state):
    return math.isfinite(state.effort[state.index("bit_axial")])


@pytest.mark.long
def test_set_points_of_a_rig_are_followed_until_they_are_stale(bench, serve, joints):
    port, commands, states = free_port(), bench.collect(RIG_COMMAND), bench.collect(RIG_STATE)
    rig = serve(sys.executable, HERE / "asyncua_rig.py", port)
    rig.ask("set", "WOBSet", 35.0)
    rig.ask("set", "RPMSet", 90.0)
    _gateway(bench, port, FOLLOW)
    status = bench.until_status("gateway", lambda one: "whose diagnostics tell its limits" in one.text)
    assert status.level == Level.WARN
    assert not commands
    # Its scene admits ten times its own set-points.
    bench.start("simulator", safe_weight_on_bit=4.0, safe_ramp_time=0.2)

    def last(messages=commands):
        state = joints(messages[-1:])[0]
        return float(state.effort[state.index("bit_axial")]), float(state.velocity[state.index("top_drive")])

    bench.until(lambda: commands and last() == (35.0, pytest.approx(1.5 * math.tau)), what="the set-points")
    bench.until(lambda: len(commands) > 5, what="more commands: a source sends at a rate")
    rig.ask("set", "WOBSet", 401.0)
    told = "control lost: weight_on_bit of the rig: expected 0 to 400 N, found 401 N; "
    bench.until_status("gateway", lambda one: one.level == Level.ERROR and one.text.startswith(told))
    bench.until(lambda: last(states) == (4.0, 0.0), what="the safe set-point")
    assert all(one.effort[one.index("bit_axial")] <= 35.0 for one in joints(commands))
    rig.ask("set", "WOBSet", 35.0)
    sent = len(commands)
    bench.until(lambda: len(commands) > sent + 5 and last()[0] == 35.0, what="the set-points again, at a rate")
    rig.kill()
    status = bench.until_status("gateway", lambda one: one.level == Level.ERROR)
    assert status.text.startswith("control lost: weight_on_bit of the rig: no connection")
    bench.until(lambda: last(states) == (4.0, 0.0), what="the safe set-point")
    rig = serve(sys.executable, HERE / "asyncua_rig.py", port)
    bench.until(lambda: last() == (10.0, pytest.approx(10.0 * math.tau / 60.0)), what="the rig's again")
    bench.until_status("gateway", lambda one: one.level == Level.OK)


@pytest.mark.long
@pytest.mark.parametrize(
    ("url", "user", "follows", "words"),
    [
        ("opc.tcp://192.0.2.7:4840", "driller", False, "the password of rig_user goes to another host"),
        ("opc.tcp://192.0.2.7:4840", "", True, "set-points of another host are followed"),
        ("wits://192.0.2.7:5001", "", True, "set-points of another host are followed"),
        ("opc.tcp://192.0.2.7:4840", "", False, ""),
        ("opc.tcp://[::1]:4840", "driller", True, ""),
        ("opc.tcp://localhost:4840", "driller", True, ""),
    ],
)
def test_neither_password_nor_set_points_cross_a_network_in_clear(url, user, follows, words):
    settings = SimpleNamespace(rig_url=url, rig_user=user, rig_security="none")
    with pytest.raises(ParameterError, match=words) if words else nullcontext():
        check_security(settings, follows=follows, has_keys=True)


def test_the_certificate_of_the_rig_must_be_trusted(bench, serve):
    port, keys, rig_keys = free_port(), bench.folder / "keys", bench.folder / "rig_keys"
    for folder in (keys, rig_keys):
        make_keys(folder, "urn:drill_twin:gateway", "localhost", {"driller": "Schlag-12"})
    serve(sys.executable, HERE / "asyncua_rig.py", port, rig_keys)
    gateway = _gateway(bench, port, SIGNALS, keys=str(keys), rig_security="sign_and_encrypt")
    status = _fault(bench, "its certificate is not in")
    assert status.text.startswith("no connection to the rig: server of the rig: ")
    assert gateway.end() == 0
    (keys / TRUSTED / "rig.der").write_bytes((rig_keys / CERTIFICATE).read_bytes())
    messages = bench.collect(MEASURED_RIG_STATE)
    _gateway(bench, port, SIGNALS, keys=str(keys), rig_security="sign_and_encrypt")
    bench.until(lambda: messages, what="a measured state")


@pytest.mark.long
@pytest.mark.parametrize("stack", ["open62541", "node-opcua"])
def test_servers_of_other_stacks_are_read(bench, serve, joints, stack):
    port, messages = free_port(), bench.collect(MEASURED_RIG_STATE)
    line, node = 'measure: {{weight_on_bit: {{node: "{}", unit: kN, stale_after: {}}}}}', "nsu=urn:rig;s=WOB"
    if stack == "open62541":
        pytest.importorskip("o6", reason="needs o6, the open62541 of Python")
        serve(sys.executable, HERE / "open62541_rig.py", port)
        line = line.format("ns=1;s=WOB", 0)  # it gives a value its stamp when it is written, here once
    else:
        modules = os.environ.get("DRILL_TWIN_NODE_MODULES", "")
        if not shutil.which("node") or not (Path(modules) / "node-opcua-server").is_dir():
            pytest.skip("needs node, and node-opcua-server in the folder DRILL_TWIN_NODE_MODULES")
        serve("node", HERE / "node_opcua_rig.js", port, NODE_PATH=modules)
        line = line.format(node, 2)
    _gateway(bench, port, line)
    bench.until(lambda: messages, 60.0, what=f"a measured state of {stack}")
    state = joints(messages[-1:])[0]
    assert state.effort[state.index("bit_axial")] == 7500.0
