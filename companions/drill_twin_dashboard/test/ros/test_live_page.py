# SPDX-License-Identifier: Apache-2.0
"""The page in a real browser (headless Chromium): it shows the values of the topics, and its sliders command."""

import json
import math
import re
import signal
import sys
import time
import urllib.request
from contextlib import contextmanager, suppress

import pytest
from browser import get, until
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.topics import RIG_STATE

STEADY = "rig.weight_on_bit.duration=0.1 s; rig.rotation.duration=0.1 s"


def _served(process):
    """The last link that was printed."""
    return until(lambda: re.findall(r"http://[\d.]+:\d+/#code=\S+", process.text), f"the page:\n{process.text}")[-1]


def _newest(socket):
    """The last picture that has come: a test that reads slower than the page sends would fall behind for ever."""
    text = socket.recv(timeout=10.0)
    with suppress(TimeoutError):
        while True:
            text = socket.recv(timeout=0.0)
    return text


@contextmanager
def _commanding(url):
    """Websocket of a page, by which it may command."""
    page, _, code = url.partition("#code=")
    with urllib.request.urlopen(urllib.request.Request(f"{page}enter", headers={"X-Code": code})) as answer:  # noqa: S310
        cookie, key = answer.headers["Set-Cookie"].partition(";")[0], answer.read().decode()
    with connect(page.replace("http", "ws") + "live", additional_headers={"Cookie": cookie}) as socket:
        socket.send(json.dumps({"key": key}))
        while json.loads(socket.recv(timeout=10.0)).get("error") != "":
            pass
        yield socket


@pytest.mark.long
def test_the_page_of_a_running_twin_shows_it_and_commands_it(bench, browse, tmp_path):
    states = bench.collect(RIG_STATE)
    page = bench.start_with(["--port", "0", "--no-browser"], "watch")
    simulator, analyzer = bench.start("simulator"), bench.start("analyzer")
    driver = bench.start("rig_driver", wait_for="simulator analyzer test", overrides=STEADY, change_time=0.2)
    bench.until(lambda: len(states) > 200, what="the string to move")
    browser = browse(_served(page))
    bench.until(lambda: browser.picture("picture.time > 2.0 && picture.scene !== null"), 40.0, "the picture")
    assert browser.text("name") == "pa6_bench"
    assert browser.text("wob") == "40.0"
    assert browser.text("rps") == "2.00"
    assert "x real time" in browser.text("factor")
    bench.until(lambda: browser.text("motion") not in {"", "unknown"}, what="the motion")
    for canvas, least in (("string", 0.01), ("orbit_mark_1", 0.004), ("orbit_mark_2", 0.004)):
        bench.until(lambda c=canvas, n=least: browser.drawn(c) > n, what=canvas)

    def applied():
        sample = JointStateReader().read(bytes(states[-1]))
        return sample.effort[sample.index("bit_axial")], sample.velocity[sample.index("top_drive")] / math.tau

    browser.slide("wob_slider", 55)
    browser.slide("rps_slider", 3)
    bench.until(lambda: applied() == (pytest.approx(55.0), pytest.approx(3.0)), what="the plan of the driver to change")
    status = bench.until_status("simulator", bool)
    assert "commands_refused_other_source" not in status.values
    # Without a driver the sliders are the single set-points.
    assert driver.end() == 0
    bench.until_status("simulator", lambda status: "/rig_driver" not in status.values["commander"])
    browser.type("wob_entry", "20")
    bench.until(lambda: applied()[0] == pytest.approx(20.0), what="the single set-point")
    browser.click("pause")
    bench.until(lambda: browser.text("pause") == "resume", what="the pause")
    browser.click("step")
    bench.until(lambda: "1 frame on" in browser.text("events"), what="the step")
    time_before = browser.picture("picture.time")
    browser.click("reset")
    assert browser.text("reset").startswith("press again")
    browser.click("reset")
    bench.until(lambda: browser.picture("picture.time") < time_before, what="the beginning")
    browser.click("pause")
    browser.type("wob_entry", "30")  # it waits for a command
    bench.until(lambda: browser.picture("picture.time") > 0.1, what="the run to go on")
    browser.screenshot(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 20_000
    for process in (page, analyzer, simulator):
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text


@pytest.mark.long
def test_a_refusal_of_the_driver_is_shown_and_an_unanswered_request_is_commanded_directly(bench, joints):
    states = bench.collect(RIG_STATE)
    page = bench.start_with(["--port", "0", "--no-browser"], "watch")
    simulator = bench.start("simulator")
    driver = bench.start("rig_driver", wait_for="simulator watch test", overrides=STEADY)
    bench.until(lambda: len(states) > 50, what="the string to move")
    with _commanding(_served(page)) as socket:

        def told():
            return json.loads(socket.recv(timeout=10.0)).get("refused", "")

        socket.send('{"rps": 1e9}')
        until(lambda: "rpm" in told(), "the refusal of the driver")
        driver.send(signal.SIGSTOP)
        socket.send('{"wob": 20}')
        bench.spin(0.5)
        driver.kill()
        bench.until(lambda: joints(states[-1:])[0].effort[3] == pytest.approx(20.0), 40.0, "the single set-point")
    for process in (page, simulator):
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text


def _texts(said):
    return {row["name"]: row["text"] for row in said["graph"]}


def test_a_source_that_dies_takes_its_values_along(bench):
    page = bench.start_with(["--port", "0", "--no-browser"], "watch")
    nodes = {name: bench.start(name) for name in ("simulator", "analyzer")}
    nodes["recorder"] = bench.start("recorder", bag=str(bench.folder / "bag_0"))
    nodes["rig_driver"] = bench.start("rig_driver", wait_for="simulator analyzer recorder test", overrides=STEADY)
    pictures = []

    def picture():
        while len(pictures) < 2 or time.monotonic() - pictures[-2][0] < 0.02:  # all that is waiting
            pictures.append((time.monotonic(), json.loads(socket.recv(timeout=10.0))))
        return pictures[-1][1]

    def shown(wanted, what):
        def happened():
            pictures.clear()
            bench.spin(0.02)
            return wanted(picture())

        until(happened, what)
        return pictures[-1][1]

    with _commanding(_served(page)) as socket:
        shown(lambda said: said["motion"]["state"] and len(said["graph"]) >= 5, "all nodes on the page")
        whole = shown(lambda said: said["ages"]["simulator"] < 1.0, "a fresh picture")
        assert whole["rig"]["wob"] is not None
        assert whole["simulator"]["factor"]

        assert nodes["rig_driver"].end() == 0  # in order: nothing to tell
        nodes["recorder"].kill()
        status = bench.until_status("watch", lambda status: "no diagnostics" in status.text)
        assert (status.level, status.text) == (1, "no diagnostics for more than 3 s of recorder")
        rows = shown(lambda said: "no diagnostics for " in _texts(said).get("recorder", ""), "the recorder to go")
        assert "rig_driver" not in _texts(rows)

        nodes["analyzer"].kill()
        # With the time: a page that had no processor for 3 s says once that all nodes are silent.
        alone = shown(lambda said: not said["motion"]["state"] and said["time"] is not None, "the motion alone to go")
        assert alone["motion"]["criterion"].startswith("no findings of the analyzer for ")
        assert not any({"orbit", "precession", "motion"} & set(mark) for mark in alone["marks"])
        assert alone["rig"]["wob"] is not None

        bench.call("/simulator/pause")
        bench.spin(4.0)
        assert shown(bool, "a picture of the paused twin")["time"] is not None
        bench.call("/simulator/resume")
        shown(lambda said: said["ages"]["simulator"] < 0.2, "time to go on")

        nodes["simulator"].kill()
        shown(lambda said: said["ages"]["simulator"] > 1.0, "the values to be stale")
        dead = shown(lambda said: said["time"] is None, "the values to go")
        assert (dead["nodes"], dead["rig"], dead["simulator"]["factor"]) == ([], {}, "")
        assert dead["simulator"]["text"].startswith("no data of the simulator for ")
        assert not any({"x", "y", "z"} & set(mark) for mark in dead["marks"])
    assert page.end() == 0, page.text
    assert "Traceback" not in page.text


def test_a_page_is_no_source_of_commands_before_a_slider_moves(bench, joints):
    states = bench.collect(RIG_STATE)
    page = bench.start_with(["--port", "0", "--no-browser", "--limit", "wob_low=10 N"], "watch")
    simulator = bench.start("simulator")
    bench.until_status("watch", bool)
    driver = bench.start("rig_driver", wait_for="simulator test", overrides=STEADY)
    status = bench.until_status("simulator", lambda status: float(status.values.get("simulated_time", 0)) > 2.0)
    assert status.values["commander"] == "/rig_driver"
    assert not any("commands were refused" in status.text for status in bench.history)
    assert driver.end() == 0
    with _commanding(_served(page)) as socket:
        bench.until_status("simulator", lambda status: not status.values["commander"])
        socket.send('{"wob": 20}')
        bench.until(lambda: joints(states[-1:])[0].effort[3] == pytest.approx(20.0), what="the single set-point")

        def said(wanted):
            picture = json.loads(_newest(socket))
            bench.spin(0.01)
            return "error" not in picture and wanted(picture) and picture

        def told(text):
            until(lambda: said(lambda picture: text in picture["events"][-1]["text"]), f"the event {text!r}")

        told("set-point: weight on bit 20 N")
        until(
            lambda: said(lambda picture: picture["limits"] == {"wob": {"low": 10.0}}), "the limit of the command line"
        )
        socket.send('{"step": true}')
        until(lambda: said(lambda picture: "expected a paused run to step" in picture["refused"]), "the refusal")
        socket.send('{"pause": true}')
        told("paused at ")
        until(lambda: said(lambda picture: picture["state"] == "paused" and not picture["refused"]), "the pause")
        socket.send('{"step": true}')
        told("1 frame on, at ")
        socket.send('{"reset": true}')
        told("began again at ")
        socket.send('{"resume": true}')
        told("running from ")
        for wrong in ('{"pause": 1}', '{"wob": true}', '{"halt": true}'):
            socket.send(wrong)
            until(lambda: json.loads(socket.recv(timeout=10.0)).get("error", "").startswith("expected wob, "), "no")
    bench.until_status("simulator", lambda status: status.values["commander"] == "")
    driver = bench.start("rig_driver", wait_for="simulator test", overrides=STEADY)
    bench.until_status("simulator", lambda status: status.values["commander"] == "/rig_driver")
    for process in (driver, page, simulator):
        assert process.end() == 0, process.text


def test_the_page_of_a_bag_plays_stops_and_goes_to_a_time(bench, browse, small_bag):
    command = [sys.executable, "-m", "drill_twin.cli", "watch", str(small_bag), "--port", "0", "--no-browser"]
    command += ["--limit", "torque_high=12 kN m", "--limit", "rps_low=30 rpm"]
    page = bench.command("page", command)
    browser = browse(_served(page))
    until(lambda: browser.picture("picture.nodes.length > 0"), "the picture")
    assert browser.value("location.href") == _served(page).partition("#")[0]  # without the code
    assert browser.value("document.referrer") == ""
    assert browser.value("document.getElementById('rig').hidden") is True
    assert browser.text("name") == "pa6_bench"
    assert browser.picture("picture.limits") == {"torque": {"high": 12e3}, "rps": {"low": pytest.approx(0.5)}}
    until(lambda: browser.text("time") == "t = 0.50 s", "the end of the recording")
    until(lambda: browser.text("play") == "play", "the pause at the end")
    browser.slide("seek", 0.1)
    until(lambda: browser.picture("0.0 < picture.time && picture.time < 0.3"), "an earlier time")
    assert page.end() == 0
    assert "Traceback" not in page.text


def test_a_page_of_another_origin_cannot_command(bench, small_bag):
    command = [sys.executable, "-m", "drill_twin.cli", "watch", str(small_bag), "--port", "0", "--no-browser"]
    url = _served(bench.command("page", command))
    live = url.partition("#")[0].replace("http", "ws") + "live"
    with connect(live) as socket:
        assert "scene" in json.loads(socket.recv(timeout=10.0))
    with pytest.raises(InvalidStatus, match="403"), connect(live, origin="http://elsewhere.example"):
        pass
    place = url.split("/")[2]
    assert get(place, "/")[0] == 200
    assert get(place, "/", Host="elsewhere.example:80")[0] == 403
    assert get(place, "/etc/passwd")[0] == 404
    with _commanding(url) as socket:
        for rubbish in ("[", '{"play": "yes"}', '{"seek": NaN}', '{"wob": 5}', "[" * 4000, b"\xff"):
            socket.send(rubbish)
        errors = []
        while len(errors) < 6:
            said = json.loads(socket.recv(timeout=10.0))
            errors += [said["error"]] if "error" in said else []
        assert all(text.startswith("expected ") for text in errors)
