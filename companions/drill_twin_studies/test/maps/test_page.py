# SPDX-License-Identifier: Apache-2.0
"""The page of a map opens from disk: what it shows of a run and of a set-point, in headless Chromium."""

import re

import pytest

from drill_twin_studies.maps.drawing import build_page, page_data

USE = """(async () => {
  await plotlyReady;
  const [i, j] = [%d, %d], map = $("map"), { xaxis, yaxis } = map._fullLayout, edge = map.getBoundingClientRect();
  const clientX = edge.left + xaxis._offset + xaxis.l2p(shown(speed(j), "rotation"));
  const clientY = edge.top + yaxis._offset + yaxis.l2p(shown(load(i), "force"));
  const event = { bubbles: true, view: window, clientX, clientY };
  const area = map.querySelector(".nsewdrag"), moved = new Promise((done) => map.once("plotly_hover", done));
  area.dispatchEvent(new MouseEvent("mousemove", event)); await moved;
  const clicked = new Promise((done) => map.once("plotly_click", done));
  area.dispatchEvent(new MouseEvent("mousedown", event)); document.dispatchEvent(new MouseEvent("mouseup", event));
  await clicked;
  $("field").value = "radius"; $("field").onchange();
  return { here: $("here").innerText, run: $("run").innerText, command: $("command").textContent,
    screen: innerWidth, width: document.documentElement.scrollWidth, run_at: D.runs[picked].node,
    legend: map.querySelector(".legend").textContent };
})()"""


def test_it_needs_nothing_from_a_network(found):
    page = build_page(found, "pa6_bench")
    assert not re.search(r"""(src|href)=["'](?!data:)""", page)
    assert "</script" not in page[page.index('id="map-data"') :].split("</script>", 1)[0]


def test_its_fields_are_those_of_the_map(found):
    data = page_data(found, "pa6_bench")
    assert [int(code) for code in data["codes"]] == found.regimes.ravel().tolist()
    assert [flag == "1" for flag in data["keeps"]] == found.keeps_whirling.ravel().tolist()
    assert len(data["commands"]) == len(data["runs"])


def test_a_browser_that_cannot_unpack_plotly_is_told_where_the_map_is(found, browse, tmp_path):
    file = tmp_path / "map.html"
    file.write_text(build_page(found, "pa6_bench").replace("new DecompressionStream", "new NoSuchStream"))
    page = browse(file.as_uri(), 1280, live=False)
    assert "map.png shows it" in page.text("map")


@pytest.mark.parametrize("width", [390, 1280])
def test_a_click_shows_the_run_and_its_command(found, browse, tmp_path, width):
    inside = range(1, found.plane.steps)  # a click on the rim of a small picture may meet its neighbour
    key = next(
        key
        for key, record in found.records.items()
        if record.whirls and key.draw == 0 and key.searches and key.i in inside and key.j in inside
    )
    file = tmp_path / "map.html"
    file.write_text(build_page(found, "pa6_bench"))
    shown = browse(file.as_uri(), width, live=False).value(USE % key.node)
    record = found.records[key]
    assert shown["run_at"] == list(key.node)
    assert record.regime.value in shown["run"]
    assert f"{record.onset_s:.4g} s" in shown["run"]
    assert shown["command"] == found.command_of(key, "pa6_bench")
    assert "to calm operation" in shown["here"]
    assert "whirl begins from rest" in shown["legend"]
    assert shown["width"] <= shown["screen"]
