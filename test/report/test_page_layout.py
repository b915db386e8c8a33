# SPDX-License-Identifier: Apache-2.0
"""Layout of the report page on a telephone and on a desk, measured in headless Chromium."""

import json
import os
import re
import shutil
import signal
import subprocess
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from queue import Queue
from threading import Thread

import pytest

from drill_twin.report.charts import CHARTS

BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
MEASURE = """
<script>addEventListener("load", () => {
  const inside = (box) => {
    const card = box.closest("section").getBoundingClientRect(), edge = box.getBoundingClientRect();
    return edge.left >= card.left && edge.right <= card.right;
  };
  const image = document.querySelector(".picture img"), picture = image.parentElement;
  const found = { screen: innerWidth, width: document.documentElement.scrollWidth,
                  inside: [...document.querySelectorAll("table, .picture")].every(inside),
                  image: image.getBoundingClientRect().width };
  picture.dispatchEvent(new MouseEvent("click", { clientX: 50 }));
  found.full = image.getBoundingClientRect().width; found.still = document.documentElement.scrollWidth;
  fetch("/found", { method: "POST", body: JSON.stringify(found) });
});</script>"""

DRAWN = """
<script>addEventListener("load", () => plotlyReady.then(() => setTimeout(() => {
  document.querySelector(".chart").scrollIntoView();
  const look = (turns) => {
    const all = (what) => [...document.querySelectorAll(what)], charts = all(".js-plotly-plot");
    if (charts.length < 4 && turns) return setTimeout(() => look(turns - 1), 250);
    fetch("/found", { method: "POST", body: JSON.stringify({
      screen: innerWidth, width: document.documentElement.scrollWidth, charted: all(".charted").length,
      drawn: charts.length, inside: charts.every((box) => box.getBoundingClientRect().right <= innerWidth),
      letters: Math.min(...all(".xtick text").map((text) => parseFloat(getComputedStyle(text).fontSize))),
      pictures: all(".charted .picture").filter((box) => box.getClientRects().length).length }) });
  };
  look(240);
}, 500)));</script>"""


@pytest.fixture
def page(known_report):
    return known_report.page


@pytest.mark.parametrize("width", [320, 390, 768, 1400])
def test_page_is_as_wide_as_the_screen_and_its_figures_legible(page, width, tmp_path):
    text = re.sub(r'<script type="text/plain".*?</script>', "", page.read_text("utf-8"), flags=re.DOTALL)  # plotly
    found = measure(text, MEASURE, width, tmp_path)
    assert found["width"] <= found["screen"]
    assert found["inside"], "a table or a figure leaves its card"
    assert found["image"] >= 700.0  # its text of 10.5 points has 10 pixels
    assert found["full"] == 1300.0
    assert found["still"] <= found["screen"]


@pytest.mark.parametrize("width", [390, pytest.param(1920, marks=pytest.mark.long)])
def test_charts_take_the_place_of_the_pictures(page, width, tmp_path):
    text = re.sub(r'<script [^>]*id="view-data".*?</script>', "", page.read_text("utf-8"), flags=re.DOTALL)  # 3-D
    found = measure(text, DRAWN, width, tmp_path)
    assert found["charted"] == len(CHARTS)
    assert found["drawn"] >= 4  # those near the screen
    assert found["inside"]
    assert found["letters"] >= 12.0
    assert found["pictures"] == 0
    assert found["width"] <= found["screen"]


def measure(text, script, width, folder):
    """What a script finds on a page in a window of this width, in real time, and sends back to the page's server."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} is installed")
    found = Queue()
    whole = text.replace("</body></html>", f"{script}</body></html>").encode()

    class Page(BaseHTTPRequestHandler):
        def do_GET(self):
            self._answer(whole if self.path == "/" else b"")

        def do_POST(self):
            found.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self._answer(b"")

        def _answer(self, content):
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_):
            pass

    words = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}", f"--window-size={width},900"]
    with ThreadingHTTPServer(("127.0.0.1", 0), Page) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        command = [browser, *words, "--remote-debugging-port=0", f"http://127.0.0.1:{server.server_port}/"]
        process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        try:
            return found.get(timeout=120.0)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # it has many children
            process.wait()
            server.shutdown()
