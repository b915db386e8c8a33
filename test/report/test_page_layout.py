# SPDX-License-Identifier: Apache-2.0
"""Layout of the report page on a telephone and on a desk, measured in headless Chromium."""

import re

import pytest
from browser import until

from drill_twin.report.charts import CHARTS

MEASURE = """(() => {
  const inside = (box) => {
    const card = box.closest("section").getBoundingClientRect(), edge = box.getBoundingClientRect();
    return edge.left >= card.left && edge.right <= card.right;
  };
  const image = document.querySelector(".picture img"), picture = image.parentElement;
  const found = { screen: innerWidth, width: document.documentElement.scrollWidth,
                  inside: [...document.querySelectorAll("table, .picture")].every(inside),
                  image: image.getBoundingClientRect().width };
  picture.dispatchEvent(new MouseEvent("click", { clientX: 50 }));
  return { ...found, full: image.getBoundingClientRect().width, still: document.documentElement.scrollWidth };
})()"""

DRAWN = """(() => {
  const all = (what) => [...document.querySelectorAll(what)], charts = all(".js-plotly-plot");
  return { screen: innerWidth, width: document.documentElement.scrollWidth, charted: all(".charted").length,
    inside: charts.every((box) => box.getBoundingClientRect().right <= innerWidth),
    letters: Math.min(...all(".xtick text").map((text) => parseFloat(getComputedStyle(text).fontSize))),
    pictures: all(".charted .picture").filter((box) => box.getClientRects().length).length };
})()"""


@pytest.fixture
def shown(known_report, browse, tmp_path):
    """Open the page in a window of a width, without the scripts that a pattern fits."""

    def begin(width, left_out):
        text = re.sub(left_out, "", known_report.page.read_text("utf-8"), flags=re.DOTALL)
        (tmp_path / "page.html").write_text(text, "utf-8")
        return browse((tmp_path / "page.html").as_uri(), width, live=False)

    return begin


@pytest.mark.parametrize("width", [320, 390, 768, 1400])
def test_page_is_as_wide_as_the_screen_and_its_figures_legible(shown, width):
    found = shown(width, r'<script type="application/json" id="plotly-packed".*?</script>').value(MEASURE)  # no plotly
    assert found["width"] <= found["screen"]
    assert found["inside"], "a table or a figure leaves its card"
    assert found["image"] >= 700.0  # its text of 10.5 points has 10 pixels
    assert found["full"] == 1300.0
    assert found["still"] <= found["screen"]


@pytest.mark.parametrize("width", [390, pytest.param(1920, marks=pytest.mark.long)])
def test_charts_take_the_place_of_the_pictures(shown, width):
    browser = shown(width, r'<script [^>]*id="view-data".*?</script>')  # no 3-D
    until(lambda: browser.value("document.querySelectorAll('.charted').length > 0"), "plotly")
    browser.value("document.querySelector('.chart').scrollIntoView()")
    until(lambda: browser.value("document.querySelectorAll('.js-plotly-plot').length >= 4"), "those near the screen")
    found = browser.value(DRAWN)
    assert found["charted"] == len(CHARTS)
    assert found["inside"]
    assert found["letters"] >= 12.0
    assert found["pictures"] == 0
    assert found["width"] <= found["screen"]


PRINTED = """(() => {
  const shown = (what) => [...document.querySelectorAll(what)].filter((box) => box.getClientRects().length);
  return { width: document.documentElement.scrollWidth, screen: innerWidth, pictures: shown(".picture").length,
    charts: shown(".chart").length, view: shown("#view").length,
    widest: Math.max(...shown(".picture img").map((image) => image.getBoundingClientRect().width)) };
})()"""


def test_a_page_on_paper_has_its_pictures_and_nothing_that_is_pressed(known_report, browse):
    """An A4 sheet has 186 mm within its margins, 703 pixels."""
    browser = browse(known_report.page.as_uri(), 703, live=False)
    until(lambda: browser.value("document.querySelectorAll('.charted').length > 0"), "plotly")
    browser.on_paper()
    found = browser.value(PRINTED)
    assert found["width"] <= found["screen"]
    assert found["widest"] <= found["screen"]
    assert found["pictures"] > 3
    assert found["charts"] == found["view"] == 0
