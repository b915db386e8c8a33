# SPDX-License-Identifier: Apache-2.0
"""The driller's screen in a real browser, of a recording: units, limits, alarms, keyboard, widths."""

import csv
import json
from pathlib import Path

import pytest
from browser import get, until
from test_advice_shown import LEAVE, lattice

from drill_twin.core.units import parse
from drill_twin.core.units.dimension import FORCE, TORQUE
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.topics import ADVICE_MAP, ADVICE_STATE, DIAGNOSTICS, ESTIMATE_STATE
from drill_twin_dashboard.live.player import Player
from drill_twin_dashboard.live.server import PageServer, page_files
from drill_twin_studies.maps.advice import encode_advice

ACCESSIBILITY = (Path(__file__).parent / "accessibility.js").read_text("utf-8")


@pytest.fixture
def page(bench_run, browse):
    player = Player(bench_run.bag)
    server = PageServer(player.snapshot, player.on_request, history=player.state.history, port=0)
    try:
        browser = browse(server.links.new())
        until(lambda: browser.picture("picture.nodes.length > 0 && picture.time > 2.9"), "the end of the recording")
        yield browser, player
    finally:
        server.close()
        player.close()


def test_the_screen_of_a_driller(page):
    browser, player = page
    # Trends: drawn by plotly from the whole recording, and saved in the units on the screen.
    until(lambda: browser.value("document.querySelectorAll('.chart .scatterlayer path').length >= 8"), "the trends")
    # Units of the reader's choice.
    wob = player.snapshot()["rig"]["wob"]
    assert float(browser.text("wob")) == pytest.approx(wob, abs=0.06)
    browser.value("units.value = 'field', units.dispatchEvent(new Event('change'))")
    sizes = browser.value("import('/units.js').then((units) => [units.size('force'), units.size('torque')])")
    assert sizes == pytest.approx([parse("1e3 lbf", FORCE), parse("1e3 ft lbf", TORQUE)], rel=1e-12)
    until(lambda: browser.text("wob_unit") == "klbf", "the unit")
    table = browser.value("import('/trends.js').then((trends) => trends.trendsTable())")
    heads, *rows = csv.reader(table.splitlines())
    assert "weight on bit, mean [klbf]" in heads
    assert len(rows) == 12
    assert {len(row) for row in rows} == {len(heads)}
    browser.value("unit_force.value = 'N', unit_force.dispatchEvent(new Event('change'))")
    until(lambda: browser.text("wob_unit") == "N" and browser.value("units.value") == "own", "the unit of one quantity")
    # A limit typed in the unit of the screen, an alarm, its acknowledgement by keyboard.
    browser.type("wob_high", "55")
    until(lambda: browser.picture("picture.limits.wob?.high") == pytest.approx(55.0), "the limit")
    browser.type("seek_entry", "0.5")
    browser.click("play")
    until(lambda: "weight on bit above its high limit" in browser.text("alarms"), "the alarm of the limit")
    assert "weight on bit above its high limit" in browser.text("announced")
    assert browser.value("wob_channel.classList.contains('beyond')")
    before = browser.picture("picture.alarms.filter((alarm) => !alarm.acknowledged).length")
    browser.value("document.querySelector('#alarms button').focus()")
    browser.press("Enter", 13)
    until(
        lambda: browser.picture("picture.alarms.filter((alarm) => !alarm.acknowledged).length") == before - 1,
        "the acknowledgement",
    )
    assert "acknowledged: " in browser.text("events")
    # The arrows turn the well.
    picture = "document.getElementById('string').toDataURL()"
    browser.value("document.getElementById('string').focus()")
    seen = browser.value(picture)
    browser.press("ArrowLeft", 37)
    until(lambda: browser.value(picture) != seen, "the view to turn")
    assert browser.value(ACCESSIBILITY) == []


def test_map_and_advice_on_the_screen_at_three_metres_and_on_a_telephone(page):
    browser, player = page
    player.state.update(ADVICE_MAP, encode_string(json.dumps(lattice())))
    player.state.update(ADVICE_STATE, encode_advice(0, LEAVE, 60.0, 6.0, whirls=False))
    names = ("trust", "alarm", "bit_torque", "bit_torque/low", "bit_torque/high", "wall_friction.coefficient",
             "wall_friction.coefficient/low", "wall_friction.coefficient/high")  # fmt: skip
    estimate = JointStateTemplate(names, velocity=False, effort=False)
    player.state.update(ESTIMATE_STATE, estimate.fill(0, [0.0, 1.0, 1.35582, 1.0, 2.0, 0.2, 0.19, 0.21]))
    told = [Status("advisor", Level.WARN, "go to 20 N"), Status("estimator", Level.WARN, "hookload leaves the band")]
    player.state.update(DIAGNOSTICS, encode_diagnostics(0, told))
    browser.width(1920, 1080)
    until(lambda: browser.value("document.querySelectorAll('#map .heatmaplayer image').length") == 1, "the map")
    assert "weight on bit [N]" in browser.text("map")
    assert browser.text("advice_text") == "go to 20 N"
    assert browser.text("estimate_text") == "hookload leaves the band"
    cells = "[...estimate_rows.rows].map((row) => [...row.cells].map((one) => one.textContent))"
    assert browser.value(cells)[1:] == [
        ["bit torque", "1.356 N m", "1.000 to 2.000"],
        ["wall_friction.coefficient", "0.2", "0.19 to 0.21"],
    ]
    choose = "(name) => { units.value = name; units.dispatchEvent(new Event('change')); }"
    browser.value(f"({choose})('field')")
    until(lambda: browser.value(cells)[1] == ["bit torque", "0.0010 klbf ft", "0.0007 to 0.0015"], "the field's units")
    browser.value(f"({choose})('laboratory')")
    assert "estimator: hookload leaves the band" in browser.text("alarms")
    until(lambda: browser.value("innerWidth") == 1920, "the width")
    assert browser.value("document.documentElement.scrollHeight") <= 1080
    # 14 mm, 16 minutes of arc at three metres, on a 24-inch screen: digits are 0.73 of the size of the font
    assert browser.value("0.73 * parseFloat(getComputedStyle(wob).fontSize)") >= 14.0 / (531.0 / 1920.0)
    wide = "[...document.querySelectorAll('.value')].filter((one) => one.scrollWidth > one.clientWidth)"
    assert browser.value(f"{wide}.map((one) => one.textContent)") == []
    for width in (390, 1024):
        browser.width(width)
        until(lambda w=width: browser.value("innerWidth") == w, "the width")
        assert browser.value("document.documentElement.scrollWidth") <= width


def test_files_come_from_this_server_only(page):
    browser, _ = page
    assert browser.value(
        "performance.getEntriesByType('resource').every((one) => one.name.startsWith(location.origin))"
    )
    place = browser.value("location.host")
    assert {name for name, _ in page_files().items()} > {"/", "/main.js", "/page.css", "/plotly.js"}
    for path in ("/", "/main.js", "/plotly.js", "/history.json"):
        assert get(place, path)[0] == 200
    for path in ("/page.html", "/../server.py", "/%2e%2e/server.py", "/etc/passwd"):
        assert get(place, path)[0] == 404
    assert len(json.loads(get(place, "/history.json")[1])["trends"]["rows"]) == 12
    inline = "s => { s.textContent = 'window.ran = true'; document.body.append(s); return window.ran === undefined; }"
    assert browser.value(f"({inline})(document.createElement('script'))")
