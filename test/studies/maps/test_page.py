# SPDX-License-Identifier: Apache-2.0
"""The page of a map opens from disk: what it shows of a run and of a set-point, in headless Chromium."""

import json
import re
import shutil
import subprocess
from html import unescape

import pytest

from drill_twin.studies.maps.drawing import build_page, page_data

BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
USE = """
<script>addEventListener("load", () => {
  const map = $("map"), edge = map.getBoundingClientRect(), [x, y] = at(%d, %d);
  const event = { clientX: edge.left + x, clientY: edge.top + y };
  map.dispatchEvent(new MouseEvent("mousemove", event)); map.dispatchEvent(new MouseEvent("click", event));
  $("field").value = "radius"; $("field").onchange();
  document.title = JSON.stringify({ here: $("here").innerText, run: $("run").innerText,
    command: $("command").textContent, screen: innerWidth, width: document.documentElement.scrollWidth,
    legend: $("legend").innerText });
});</script>"""


def test_it_needs_nothing_from_a_network(found):
    page = build_page(found, "pa6_bench")
    assert not re.search(r"""(src|href)=["'](?!data:)""", page)
    assert "</script" not in page[page.index('id="data"') :].split("</script>", 1)[0]


def test_its_fields_are_those_of_the_map(found):
    data = page_data(found, "pa6_bench")
    assert [int(code) for code in data["codes"]] == found.regimes.ravel().tolist()
    assert [flag == "1" for flag in data["keeps"]] == found.keeps_whirling.ravel().tolist()
    assert len(data["commands"]) == len(data["runs"])


@pytest.mark.parametrize("width", [390, 1280])
def test_a_click_shows_the_run_and_its_command(found, tmp_path, width):
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} is installed")
    key = next(key for key, record in found.records.items() if record.whirls and key.draw == 0 and not key.origin)
    file = tmp_path / "map.html"
    file.write_text(build_page(found, "pa6_bench").replace("</body>", USE % key.node + "</body>"))
    options = ["--headless", "--no-sandbox", "--disable-gpu", f"--window-size={width},900", "--dump-dom"]
    done = subprocess.run([browser, *options, file.as_uri()], capture_output=True, text=True, timeout=120, check=True)
    shown = json.loads(unescape(re.search(r"<title>(.*?)</title>", done.stdout, re.DOTALL)[1]))
    record = found.records[key]
    assert record.regime.value in shown["run"]
    assert f"{record.onset_s:.4g} s" in shown["run"]
    assert shown["command"] == found.command_of(key, "pa6_bench")
    assert "to calm operation" in shown["here"]
    assert "whirl begins from rest" in shown["legend"]
    assert shown["width"] <= shown["screen"]
