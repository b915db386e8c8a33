# SPDX-License-Identifier: Apache-2.0
"""Commands through the gateway: a client process with certificate, user, grant and heartbeat; what others may not."""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest
from ports import free_port

asyncua = pytest.importorskip("asyncua", reason="needs asyncua: pip install 'drill_twin[opcua]'")

from drill_twin.io.messages.diagnostics import Level  # noqa: E402
from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE  # noqa: E402
from drill_twin_rig.gateway.opc_ua.keys import CERTIFICATE, TRUSTED, make_keys  # noqa: E402

HERE = Path(__file__).resolve().parent / "clients"
STEADY = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"
PASSWORD = "Schlag-12"  # noqa: S105 - of this test only


class Holder:
    """A client process that is told what to do."""

    def __init__(self, url, keys, server, user="driller", password=PASSWORD):
        words = [url, str(keys), str(server / CERTIFICATE), user, password]
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / "asyncua_holder.py"), *words],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        self.connected = self._answer()

    def _answer(self):
        return json.loads(self._process.stdout.readline() or '"ended"')

    def ask(self, *words):
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()
        return self._answer()

    def kill(self):
        self._process.kill()
        self._process.wait()


@pytest.fixture(scope="module")
def rig(module_bench, tmp_path_factory):
    """A twin that waits for commands, a gateway with keys, and clients by `rig.client`."""
    folder = tmp_path_factory.mktemp("control")
    server, trusted, stranger = (folder / name for name in ("server", "client", "stranger"))
    for keys in (server, trusted, stranger):
        make_keys(keys, "urn:drill_twin:gateway", "localhost", {"driller": PASSWORD})
    (server / TRUSTED / "client.der").write_bytes((trusted / CERTIFICATE).read_bytes())
    bench = module_bench(folder)
    port = free_port()
    bench.start("simulator", overrides=STEADY, safe_weight_on_bit=5.0, safe_ramp_time=0.2)
    bench.gateway = bench.start("gateway", port=port, keys=str(server), heartbeat_timeout=3.0)
    bench.until_status("gateway", bool)
    url, clients = f"opc.tcp://127.0.0.1:{port}/drill_twin", []

    def client(keys=trusted, **given):
        clients.append(Holder(url, keys, server, **given))
        return clients[-1]

    bench.client, bench.stranger, bench.url = client, stranger, url
    yield bench
    for one in clients:
        one.kill()


def test_a_client_without_certificate_is_not_let_in(rig):
    done = subprocess.run(
        [sys.executable, str(HERE / "asyncua_client.py"), "read", rig.url], capture_output=True, text=True, check=False
    )
    assert done.returncode
    assert "policy" in done.stderr.lower()


def test_an_unknown_certificate_is_refused_and_told(rig):
    assert rig.client(rig.stranger).connected == "BadCertificateUntrusted"
    status = rig.until_status("gateway", lambda status: status.text.startswith("refused: client"))
    assert status.level == Level.WARN
    assert "its certificate is not in" in status.text


def test_a_wrong_password_is_refused_and_told(rig):
    assert rig.client(password="guess").connected == "BadUserAccessDenied"  # noqa: S106
    status = rig.until_status("gateway", lambda status: "the password is wrong" in status.text)
    assert int(status.values["refused_user"]) == 1


def test_control_is_granted_used_lost_and_given_back(rig, joints):
    states, commands = rig.collect(RIG_STATE), rig.collect(RIG_COMMAND)
    holder = rig.client()
    assert holder.connected == "connected"
    assert holder.ask("write", "WOBTarget", 30.0) == "BadUserAccessDenied"  # nobody has granted it
    assert holder.ask("write", "Request", True) == "Good"
    holder.ask("beat", 0.2)
    rig.until_status("gateway", lambda status: status.text == "driller requests control: call ~/grant_control")
    assert holder.ask("write", "WOBTarget", 30.0) == "BadUserAccessDenied"
    assert not commands
    assert rig.call("/gateway/grant_control").success
    rig.until_status("gateway", lambda status: status.values["holder"] == "driller")
    assert holder.ask("read", "Permission") == 1

    assert holder.ask("write", "WOBTarget", 30.0) == "Good"
    assert holder.ask("write", "SurfaceRPMTarget", 60.0) == "Good"
    rig.until(lambda: states and _applied(joints(states[-1:])[0]) == pytest.approx((30.0, math.tau)), what="the target")
    assert holder.ask("write", "WOBTarget", math.nan) == "BadOutOfRange"
    assert holder.ask("write", "WOBTarget", -1.0) == "BadOutOfRange"
    assert holder.ask("write", "WOBTarget", 1e308) == "BadOutOfRange"
    assert holder.ask("write", "WOBTarget", 401.0) == "BadOutOfRange"  # ten times the scene's
    assert holder.ask("write", "SurfaceRPMTarget", 1e308) == "BadOutOfRange"
    other = rig.client()
    assert other.ask("write", "WOBTarget", 99.0) == "BadUserAccessDenied"
    assert other.ask("write", "Request", True) == "BadUserAccessDenied"

    holder.ask("beat", 0.0)
    status = rig.until_status("gateway", lambda status: status.level == Level.ERROR)
    assert status.text == "control lost: no heartbeat of driller for 3 s; the simulator does what its on_silence says"
    rig.until(lambda: _applied(joints(states[-1:])[0]) == pytest.approx((5.0, 0.0)), what="the safe set-point")
    assert holder.ask("write", "WOBTarget", 30.0) == "BadUserAccessDenied"
    assert all(30.0 >= _applied(one)[0] >= 0.0 for one in joints(states))
    assert holder.ask("read", "Permission") == 4

    rig.set_parameter("gateway", "grant", "always")
    assert other.ask("write", "Request", True) == "Good"
    other.ask("beat", 0.2)
    rig.until_status("gateway", lambda status: status.values["holder"] == "driller" and status.level != Level.ERROR)
    assert other.ask("write", "WOBTarget", 12.0) == "Good"
    rig.until(lambda: _applied(joints(states[-1:])[0])[0] == pytest.approx(12.0), what="the target of the other")
    assert other.ask("write", "Request", False) == "Good"
    rig.until(lambda: rig.node.count_publishers(RIG_COMMAND) == 0, what="the gateway to leave /rig/command")


def test_the_limits_are_the_simulator_s_also_when_they_change(rig):
    """401 N was answered Good where the simulator takes 60 N."""
    rig.set_parameter("gateway", "grant", "always")
    assert rig.set_parameter("simulator", "max_weight_on_bit", 60.0).successful
    holder = rig.client()
    assert holder.ask("write", "Request", True) == "Good"
    holder.ask("beat", 0.2)
    rig.until(lambda: holder.ask("read", "Permission") == 1, what="control")
    rig.until(lambda: holder.ask("write", "WOBTarget", 60.5) == "BadOutOfRange", what="the limit of the simulator")
    assert holder.ask("write", "WOBTarget", 60.0) == "Good"
    rig.until_status("simulator", lambda status: float(status.values["weight_on_bit"]) == 60.0)
    assert holder.ask("read", "Refusal") == ""
    # The set-point in force is beyond the new limit: the twin refuses it, which the client can read.
    assert rig.set_parameter("simulator", "max_weight_on_bit", 50.0).successful
    rig.until(lambda: "expected 0 to 50 N, found 60 N" in holder.ask("read", "Refusal"), what="the refusal of the twin")
    rig.until_status("gateway", lambda status: status.text.startswith("the twin refuses the set-point: weight on bit"))
    assert holder.ask("write", "WOBTarget", 50.0) == "Good"
    rig.until(lambda: holder.ask("read", "Refusal") == "", what="the end of the refusal")
    assert rig.set_parameter("simulator", "max_weight_on_bit", 0.0).successful
    rig.until(lambda: holder.ask("write", "WOBTarget", 100.0) == "Good", what="the limit of the scene")
    assert holder.ask("write", "Request", False) == "Good"


def test_while_no_simulator_has_told_its_limits_a_write_is_not_called_good(bench):
    keys, client = bench.folder / "server", bench.folder / "client"
    for folder in (keys, client):
        make_keys(folder, "urn:drill_twin:gateway", "localhost", {"driller": PASSWORD})
    (keys / TRUSTED / "client.der").write_bytes((client / CERTIFICATE).read_bytes())
    file = bench.folder / "signals.yaml"
    file.write_text(
        "command:\n"
        "  WOBTarget: {value: weight_on_bit, unit: kN, low: 0, high: 1}\n"
        "  RPMTarget: {value: surface_rotation, unit: rpm}\n"
    )
    port = free_port()
    process = bench.start("gateway", port=port, keys=str(keys), signals=str(file), grant="always")
    bench.until_status("gateway", bool)
    assert f"signals at opc.tcp://127.0.0.1:{port}/drill_twin; security policy Basic256Sha256" in process.text
    assert f"keys in {keys}" in process.text
    holder = Holder(f"opc.tcp://127.0.0.1:{port}/drill_twin", client, keys)
    try:
        assert holder.ask("write", "Request", True) == "Good"
        holder.ask("beat", 0.2)
        bench.until(lambda: holder.ask("read", "Permission") == 1, what="control")
        assert holder.ask("write", "WOBTarget", 0.5) == "GoodCompletesAsynchronously"
        assert holder.ask("write", "WOBTarget", 1.5) == "BadOutOfRange"
        assert holder.ask("write", "RPMTarget", 10.0) == "BadOutOfRange"  # neither file nor simulator limits it
        bench.start("simulator", max_weight_on_bit=60.0)
        bench.until(lambda: holder.ask("write", "WOBTarget", 0.4) == "BadOutOfRange", what="the simulator's limits")
        assert holder.ask("write", "WOBTarget", 0.06) == "Good"
    finally:
        holder.kill()


@pytest.mark.long
def test_nobody_gets_control_beside_a_driver(rig):
    rig.set_parameter("gateway", "grant", "always")
    driver = rig.start("rig_driver", overrides=STEADY)
    rig.until_status("rig_driver", lambda status: int(status.values["commands_sent"]) > 0)
    holder = rig.client()
    assert holder.ask("write", "Request", True) == "Good"
    status = rig.until_status("gateway", lambda status: status.text.startswith("control denied"))
    assert status.text == "control denied: /rig_driver commands"
    assert holder.ask("read", "Permission") == 3
    assert driver.end() == 0


def _applied(state):
    return state.effort[state.index("bit_axial")], state.velocity[state.index("top_drive")]


def test_keys_are_made_by_the_command_and_none_is_needed_on_this_host_only(bench):
    asked = ["ros", "keys", "keys", "--user", "me", "--password", "you and me"]
    command = [sys.executable, "-m", "drill_twin.cli", *asked]
    assert bench.command("keys", command).wait() == 0
    keys = bench.folder / "keys"
    assert (keys / "private_key.pem").stat().st_mode & 0o77 == 0
    assert "you and me" not in (keys / "users.yaml").read_text("utf-8")
    process = bench.start("gateway", host="0.0.0.0")  # noqa: S104 - that it refuses
    assert process.wait() == 2
    assert "expected an address of this host only" in process.text
    (keys / "users.yaml").chmod(0o644)
    process = bench.start("gateway", keys=str(keys))
    assert process.wait() == 2
    assert "expected a file that its owner alone reads, found mode 644; chmod 600 " in process.text
    process = bench.start("gateway", keys=str(bench.folder))
    assert process.wait() == 2
    assert "expected a folder of keys with certificate.der" in process.text


@pytest.mark.parametrize("host", ["::1", pytest.param("localhost", marks=pytest.mark.long)])
def test_without_keys_this_host_may_be_called_by_any_of_its_names(bench, host):
    port = free_port()
    process = bench.start("gateway", host=host, port=port)
    bench.until_status("gateway", bool)
    shown = f"[{host}]" if ":" in host else host
    assert f"signals at opc.tcp://{shown}:{port}/drill_twin" in process.text
    done = subprocess.run(
        [sys.executable, str(HERE / "asyncua_client.py"), "read", f"opc.tcp://{shown}:{port}/drill_twin"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert process.end() == 0


@pytest.mark.fault(
    "gateway killed (-9) while its client has control", "a ramp to the safe set-point after the age limit"
)
def test_the_twin_goes_to_the_safe_set_point_when_a_gateway_in_control_is_killed(rig, joints):
    """Last of this file: the gateway is gone."""
    states, commands, holder = rig.collect(RIG_STATE), rig.collect(RIG_COMMAND), rig.client()
    rig.set_parameter("gateway", "grant", "always")
    assert holder.ask("write", "Request", True) == "Good"
    holder.ask("beat", 0.2)
    rig.until_status("gateway", lambda status: status.values["holder"] == "driller")
    assert holder.ask("write", "WOBTarget", 25.0) == "Good"  # once; the gateway repeats it
    rig.until(lambda: states and _applied(joints(states[-1:])[0])[0] == pytest.approx(25.0), what="the target")
    sent = len(commands)
    rig.until(lambda: len(commands) > sent + 5, what="more commands: a source sends at a rate")
    rig.gateway.kill()
    rig.until(lambda: _applied(joints(states[-1:])[0]) == pytest.approx((5.0, 0.0)), what="the safe set-point")
    status = rig.until_status("simulator", lambda status: "no valid command" in status.text)
    assert status.text.endswith("; ramping to the safe set-point")
    assert status.level == Level.WARN
