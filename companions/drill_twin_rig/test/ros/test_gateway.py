# SPDX-License-Identifier: Apache-2.0
"""The gateway as a process between a simulator and OPC UA clients that are processes of other stacks, over loopback."""

import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from ports import free_port

asyncua = pytest.importorskip("asyncua", reason="needs asyncua: pip install 'drill_twin[opcua]'")

from drill_twin.core.severity import Grade  # noqa: E402
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics  # noqa: E402
from drill_twin.io.messages.topic_words import digest_of  # noqa: E402
from drill_twin.io.messages.topics import DIAGNOSTICS  # noqa: E402
from drill_twin.scene import load_scene  # noqa: E402
from drill_twin.whirl import MotionCode  # noqa: E402
from drill_twin_rig.gateway.dwis import PROPOSED, PROTOTYPES  # noqa: E402
from drill_twin_rig.gateway.opc_ua.server import MOST_CLIENTS  # noqa: E402
from drill_twin_studies.maps import OperatingMap, Plane, Regime, Span  # noqa: E402
from drill_twin_studies.maps.runs import Key, RunRecord  # noqa: E402

HERE = Path(__file__).resolve().parent / "clients"
STEADY = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
GOOD, UNCERTAIN = 0, 0x40900000


def run(*command, **environment):
    """Answer of a client: the JSON among the lines that it prints."""
    done = subprocess.run(
        [*map(str, command)],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(next(line for line in reversed(done.stdout.splitlines()) if line[:1] in {"{", '"'}))


def client(*words):
    """Answer of the client of asyncua."""
    return run(sys.executable, HERE / "asyncua_client.py", *words)


def _map(file):
    """Map of the scene that is calm up to 10 N, whatever the speed."""
    scene, plane = load_scene("pa6_bench"), Plane(Span(0.0, 80.0), Span(0.0, 8.0 * math.pi), 8)
    calm = {Key(i, j): RunRecord(Regime.FORWARD if i >= 2 else Regime.SMOOTH) for i in range(9) for j in range(9)}
    made_up = OperatingMap(scene.name, digest_of(scene), scene.to_yaml(), plane, 10.0, (), calm)
    file.write_text(json.dumps(made_up.to_dict()), "utf-8")
    return str(file)


@pytest.fixture(scope="module")
def twin(module_bench, tmp_path_factory):
    """A driven twin with a gateway, and the gateway's address."""
    bench = module_bench(tmp_path_factory.mktemp("gateway"))
    bench.port = free_port()
    bench.gateway = bench.start("gateway", port=bench.port)
    bench.start("analyzer")
    bench.start("advisor", map=_map(bench.folder / "map.json"))
    bench.simulator = bench.start("simulator", overrides=STEADY)
    bench.start("rig_driver", wob="40 N", rpm="2 rev/s", change_time=0.0, overrides=STEADY)
    bench.url = f"opc.tcp://127.0.0.1:{bench.port}/drill_twin"
    bench.until_status("gateway", lambda status: status.text == "showing the twin")
    bench.until(lambda: bench.simulated_time() > 1.0, what="a second of the run")
    return bench


@pytest.fixture(scope="module")
def found(twin):
    """What a client without rights reads, may write, and reads then."""
    return client("all", twin.url)


def test_a_client_reads_the_twin_in_the_units_of_the_file(found):
    read = found["read"]
    values = {name: one["value"] for name, one in read.items()}
    assert values["WOB"] == pytest.approx(40.0)
    assert values["SurfaceRPM"] == pytest.approx(120.0)
    assert values["BitDepth"] == pytest.approx(5.0, rel=0.01)
    assert values["HookLoad"] < 0.0 < values["SurfaceTorque"] + 1.0
    assert read["SurfaceRPM"]["unit"] == "rpm"
    assert read["SurfaceRPM"]["unit_id"] == int.from_bytes(b"RPM", "big")
    assert read["WOB"]["status"] == GOOD
    assert read["ROP"]["status"] != GOOD  # this bit does not drill
    assert found["later"]["SimulatedTime"]["value"] > values["SimulatedTime"]


def test_semantics_are_references_to_nodes_of_the_vocabulary(found):
    facts = found["semantics"]
    assert set(facts) >= set(PROTOTYPES) | set(PROPOSED)
    assert facts["WOB"]["BelongsToClass"] == ["http://ddhub.no/ComputedData", "http://ddhub.no/WOB"]
    assert facts["WOB"]["IsOfMeasurableQuantity"] == ["http://ddhub.no/ForceDrillingQuantity"]
    assert facts["WOB"]["IsPhysicallyLocatedAt"] == ["urn:drill_twin:gateway/BottomOfStringReferenceLocation#01"]
    assert facts["WOB"]["IsComputedBy"] == ["urn:drill_twin:gateway/Simulator#01"]
    assert facts["WOB"]["HasUnitOfMeasure"] == ["http://ddhub.no/Newton"]
    assert "urn:drill_twin:proposed/WhirlRPM" in facts["WhirlRPM"]["BelongsToClass"]
    assert facts["WhirlRPM"]["IsRelatedToDrillingIncident"] == ["urn:drill_twin:gateway/Whirling#01"]


def _by_terms(twin, *facts):
    """Data points that a client of D-WIS finds by facts."""
    return list(run(sys.executable, HERE / "dwis_client.py", twin.url, *facts).values())


def _only(points):
    (point,) = points
    return point


def test_a_client_that_knows_d_wis_alone_finds_the_whirl_by_its_features(twin):
    kinds = ("Forward", "Backward", "Chaotic")

    def now():
        found = {kind: _only(_by_terms(twin, f"AccountsFor=DrillStem{kind}WhirlingFeature")) for kind in kinds}
        return sum(one["good"] * one["value"] for one in found.values())

    twin.until(lambda: now() == 1.0, 120.0, "a whirl of one kind")
    for kind in kinds:
        assert _only(_by_terms(twin, f"IsRelatedToDrillingIncident={kind}Whirl"))["value"] in {0.0, 1.0}
    whirl = _by_terms(twin, "AccountsFor=DrillStemWhirlingFeature", "BelongsToClass=ComputedData")
    assert all(one["good"] for one in whirl)
    by_class = {name: one for one in whirl for name in one["classes"]}
    assert by_class["WhirlDetected"]["value"] == 1.0
    assert by_class["WhirlOnsetTime"]["value"] > 0.0
    assert by_class["WhirlOnsetTime"]["unit"] == ["Second"]
    assert 0.0 < by_class["WhirlConfidence"]["value"] <= 1.0
    assert by_class["WhirlSeverity"]["value"] in {float(grade) for grade in Grade}
    assert by_class["WhirlState"]["value"] >= MotionCode.SYNCHRONOUS_WHIRL
    assert abs(by_class["WhirlRatio"]["value"]) < 20.0
    lateral = _by_terms(twin, "AccountsFor=DrillStemLateralVibrationFeature", "BelongsToClass=ComputedData")
    assert {name for one in lateral for name in one["classes"]} >= {*by_class, "DownholeLateralAcceleration"}


def test_a_client_that_knows_d_wis_alone_finds_the_advice_and_the_safe_limits(twin):
    def found(*facts):
        return _only(_by_terms(twin, *facts, "AccountsFor=DrillStemWhirlingFeature"))

    twin.until(lambda: found("BelongsToClass=AdvisedTarget", "BelongsToClass=WOB")["good"], 120.0, "advice")
    assert found("BelongsToClass=AdvisedTarget", "BelongsToClass=WOB")["value"] <= 10.0
    for limit, largest, unit in (("WOBLimit", 10.0, "Newton"), ("RotationalVelocityLimit", 240.0, "Rpm")):
        for kind, edge in (("Minimum", 0.0), ("Maximum", largest)):
            point = found(f"IsRelatedToDrillingLimit={limit}", f"BelongsToClass=Advised{kind}")
            assert (point["good"], point["value"], point["unit"]) == (True, pytest.approx(edge), [unit])


def test_nothing_can_be_written_by_a_client_without_rights(found):
    assert found["written"] == "BadUserAccessDenied"
    assert found["later"]["WOB"]["value"] == pytest.approx(40.0)


@pytest.mark.long
def test_open62541_reads_the_same(twin):
    pytest.importorskip("o6", reason="needs o6, the open62541 of Python")
    assert run(sys.executable, HERE / "open62541_client.py", twin.url)["SurfaceRPM"] == pytest.approx(120.0)


@pytest.mark.long
def test_node_opcua_reads_the_same(twin):
    modules = os.environ.get("DRILL_TWIN_NODE_MODULES", "")
    if not shutil.which("node") or not (Path(modules) / "node-opcua-client").is_dir():
        pytest.skip("needs node, and node-opcua-client in the folder DRILL_TWIN_NODE_MODULES")
    read = run("node", HERE / "node_opcua_client.js", twin.url, NODE_PATH=modules)
    assert read["SurfaceRPM"] == pytest.approx(120.0)


@pytest.mark.long
def test_a_twin_that_falls_silent_leaves_uncertain_values_and_comes_back(twin):
    twin.simulator.send(signal.SIGSTOP)
    try:
        status = twin.until_status("gateway", lambda status: "WOB" in status.values["stale"].split())
        assert "the twin is silent" in status.text
        time.sleep(0.3)
        read = client("read", twin.url)
        assert read["WOB"]["status"] == UNCERTAIN
        assert read["WOB"]["value"] == pytest.approx(40.0)
    finally:
        twin.simulator.send(signal.SIGCONT)
    twin.until_status("gateway", lambda status: status.text == "showing the twin")
    time.sleep(0.3)
    assert client("read", twin.url)["WOB"]["status"] == GOOD


@pytest.mark.fault("32 connections that say nothing", "the oldest are closed: a client is let in at once")
def test_silent_connections_do_not_keep_a_client_out(twin):
    silent = [socket.create_connection(("127.0.0.1", twin.port), 10.0) for _ in range(MOST_CLIENTS)]
    try:
        twin.until_status("gateway", lambda status: int(status.values.get("refused_silent", 0)) >= 8)
        read = client("read", twin.url)
        still_open = [_is_open(one) for one in silent]
    finally:
        for one in silent:
            one.close()
    assert read["SurfaceRPM"]["value"] == pytest.approx(120.0)
    assert still_open[-1]
    assert not any(still_open[:8])  # the oldest first


def _is_open(connection):
    connection.setblocking(False)
    try:
        return bool(connection.recv(1))
    except BlockingIOError:
        return True


def test_odd_diagnostics_are_told_once_and_do_not_make_the_twin_silent(twin):
    publisher = twin.publisher(DIAGNOSTICS)
    odd = Status("other", Level.OK, "", {"range_weight_on_bit": "oops"}, "drill_twin")
    publisher.publish(encode_diagnostics(0, [odd]))
    twin.until_status("gateway", lambda status: "a message could not be read: /diagnostics: " in status.text)
    twin.until_status("gateway", lambda status: status.text == "showing the twin")


def test_a_taken_port_is_one_line(bench):
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        one.listen()
        process = bench.start("gateway", port=one.getsockname()[1])
        assert process.wait() == 1
    assert process.text.count("\n") == 1
    assert "expected a free port at opc.tcp://127.0.0.1:" in process.text


def test_without_the_library_one_sentence_says_what_to_install(bench):
    code = (
        "import sys; sys.modules['asyncua'] = None; "
        "from drill_twin.ros.entry_points import start; sys.exit(start('gateway', []))"
    )
    process = bench.command("gateway", [sys.executable, "-c", code])
    assert process.wait() == 2
    assert process.text == (
        "gateway: error: expected the Python module 'asyncua', found none; pip install 'drill_twin[opcua]'\n"
    )
