# SPDX-License-Identifier: Apache-2.0
"""The front door in a real browser: a well from tables at two widths, strangers' names and reports, other tabs."""

import json
from pathlib import Path

import pytest
from browser import until

from drill_twin.scene.paths import config_dir

WELLS = config_dir() / "wells"
ACCESSIBILITY = (Path(__file__).parents[1] / "live" / "accessibility.js").read_text("utf-8")
FOLDER = "document.getElementById('folder').textContent"


@pytest.fixture
def page(front, browse):
    browser = browse(front.server.links.new(), live=False)
    until(lambda: browser.value(FOLDER) == str(front.folder), "the folder")
    return browser


def put(browser, name, text):
    browser.value(f"document.getElementById('{name}').value = {json.dumps(text)}")


def press(browser, place, label):
    """Press the first button of a place that has this label."""
    found = f"[...document.querySelectorAll('{place} button')].find((one) => one.textContent === {json.dumps(label)})"
    until(lambda: browser.value(f"{found} !== undefined"), f"the button {label}")
    browser.value(f"{found}.click()")


def ended(browser, number):
    """State and output of the newest of so many commands."""
    card = "document.querySelector('.card')"
    count = "document.querySelectorAll('.card').length"
    until(lambda: browser.value(f"{count} === {number} && !{card}.classList.contains('runs')"), "its end", 300.0)
    return browser.value(f"{card}.querySelector('.head b').textContent"), browser.value(
        f"{card}.querySelector('pre').textContent"
    )


def fits(browser, width):
    """Check a width: nothing reaches beyond it, each text can be read, each control has a name."""
    browser.width(width, 1080 if width > 900 else 844)
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.value(ACCESSIBILITY) == []


def test_a_well_from_pasted_tables_at_two_widths(front, page):
    page.value("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    for width in (1920, 390):
        fits(page, width)
        entries = "[...document.querySelectorAll('#form .field')].map((one) => one.offsetWidth)"
        assert len(page.value(f"[...new Set({entries})]")) == 1  # also of what was folded away
    page.value("document.querySelectorAll('details').forEach((one) => { one.open = false; })")
    put(page, "field_name", "north 1")
    put(page, "field_survey", "md,inc\n0,0\n")
    put(page, "field_tally", (WELLS / "drillbotics_tally.csv").read_text("utf-8"))
    put(page, "field_hole", "40 mm")
    put(page, "field_wob", "150 N")
    press(page, "#form", "scene new")
    state, said = ended(page, 1)
    assert state == "exit code 2"
    assert said.startswith(
        "drill-twin: error: north_1_survey.csv, line 1: expected the columns md, inclination, azimuth"
    )
    # The file of a survey is read where it is chosen, in the code page of Windows too.
    chosen = (WELLS / "drillbotics_survey.csv").read_text("utf-8").replace("[deg]", "[°]").encode("windows-1252")
    page.value(
        f"(() => {{ const file = document.querySelector('input[type=file]'), transfer = new DataTransfer();"
        f"transfer.items.add(new File([new Uint8Array({list(chosen)})], 'survey.csv')); file.files = transfer.files;"
        f"file.dispatchEvent(new Event('change')); }})()"
    )
    until(
        lambda: page.value("document.getElementById('field_survey').value").startswith("md [m],inclination [°]"), "it"
    )
    press(page, "#form", "scene new")
    assert ended(page, 2)[0] == "done"

    press(page, "#scenes", "statics")
    assert page.text("task_name") == "statics: north_1.yaml"
    press(page, "#form", "statics")
    state, said = ended(page, 3)
    assert (state, "hookload" in said) == ("done", True)
    picture = "document.querySelector('.card img')"
    until(lambda: page.value(f"{picture}?.complete && {picture}.naturalWidth > 500"), "the picture")
    for width in (1920, 390):
        fits(page, width)

    press(page, "#scenes", "compare")
    press(page, "#scenes", "compare")  # a second case, to be changed
    assert page.value("document.getElementById('field_cases').value") == "north_1.yaml\nnorth_1.yaml\n"
    put(page, "field_cases", "../north_1.yaml\n")
    press(page, "#form", "compare")
    until(lambda: page.text("trouble").startswith("expected a file or folder in "), "the refusal")
    assert len(front.commands()) == 3


REPORT = """<!doctype html><title>a report</title><p id="said"></p><script>
const tried = (name, act) => { try { return `${name}: ${act()}`; } catch (error) { return `${name}: ${error.name}`; } };
const said = [tried("origin", () => origin), tried("storage", () => localStorage.drill_twin_key)];
said.push(tried("cookie", () => document.cookie));
const show = () => { document.getElementById("said").textContent = said.join(", "); };
Promise.allSettled([fetch("/forms.js"), fetch("report.html", { mode: "no-cors" })]).then((all) => {
  said.push(...all.map(({ status }) => `fetch: ${status}`)); show();
  const socket = new WebSocket(`ws://${location.host}/live`);
  socket.onopen = () => { said.push("socket: open"); show(); };
  socket.onerror = () => { said.push("socket: error"); show(); };
}).catch((error) => { said.push(`socket: ${error.name}`); show(); });
</script>"""


def test_a_name_is_text_and_a_strangers_report_reaches_nothing(front, page):
    name = "<img src=x onerror=document.title='taken'>.yaml"
    (front.folder / name).write_text("string:\n", "utf-8")
    (front.folder / "out").mkdir()
    (front.folder / "out" / "report.html").write_text(REPORT, "utf-8")
    until(lambda: page.value("document.querySelector('#scenes b')?.textContent") == name, "the scene")
    until(lambda: page.value("document.querySelector('#results a')?.textContent") == "report.html", "the report")
    assert page.value("document.querySelectorAll('#stock img').length") == 0
    press(page, "#scenes", "run")
    assert page.text("task_name") == f"run: {name}"
    assert page.value("document.title") == "drill_twin: scenes and results"
    at = page.value("document.querySelector('#results a').href")
    page.tab(at)
    until(lambda: "socket: " in page.text("said"), "what the report could do")
    assert page.text("said") == (
        "origin: null, storage: SecurityError, cookie: SecurityError, fetch: rejected, fetch: rejected, socket: error"
    )
    assert front.commands() == []


def test_a_reload_and_another_tab_keep_the_right_and_a_page_without_it_is_told_nothing(front, page, browse):
    page.reload()
    until(lambda: page.value(FOLDER) == str(front.folder), "the folder after a reload")
    page.tab(front.server.url)
    until(lambda: page.value(FOLDER) == str(front.folder), "the folder in another tab")
    other = browse(front.server.url, live=False, profile="another")
    assert other.value(FOLDER) == "waiting: open the link that drill-twin watch printed last"
    other.value("document.getElementById('live').click()")
    press(other, "#form", "watch")
    assert front.commands() == []
