# SPDX-License-Identifier: Apache-2.0
"""Layout of the report page on a telephone and on a desk, measured in headless Chromium."""

import json
import re
import shutil
import subprocess
from html import unescape

import pytest

from drill_twin.report import build_report

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
  document.title = JSON.stringify(found);
});</script>"""


@pytest.fixture(scope="module")
def page(known_bag, tmp_path_factory):
    return build_report(known_bag, tmp_path_factory.mktemp("layout")).page


@pytest.mark.parametrize("width", [320, 390, 768, 1400])
def test_page_is_as_wide_as_the_screen_and_its_figures_legible(page, width, tmp_path):
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} is installed")
    measured = tmp_path / "page.html"
    text = re.sub(r'<script type="text/plain".*?</script>', "", page.read_text("utf-8"), flags=re.DOTALL)  # plotly
    measured.write_text(text.replace("</body>", f"{MEASURE}</body>"), "utf-8")
    words = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}", f"--window-size={width},900"]
    dom = subprocess.run([browser, *words, "--dump-dom", measured.as_uri()], capture_output=True, text=True, check=True)
    found = json.loads(unescape(re.search("<title>(.*?)</title>", dom.stdout)[1]))
    assert found["width"] <= found["screen"]
    assert found["inside"], "a table or a figure leaves its card"
    assert found["image"] >= 700.0  # its text of 10.5 points has 10 pixels
    assert found["full"] == 1300.0
    assert found["still"] <= found["screen"]
