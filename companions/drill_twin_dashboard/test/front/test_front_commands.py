# SPDX-License-Identifier: Apache-2.0
"""A well from pasted tables to its report, by the page alone: real commands, over HTTP and the websocket."""

import json
import os
import re
import signal

import pytest
from browser import get, until

from drill_twin.scene import load_scene
from drill_twin.scene.paths import config_dir

pytestmark = pytest.mark.process
SURVEY = (config_dir() / "wells" / "drillbotics_survey.csv").read_text("utf-8")
TALLY = (config_dir() / "wells" / "drillbotics_tally.csv").read_text("utf-8")
TABLES = {"--survey": SURVEY, "--tally": TALLY}
DEEP = {f"--{of}": (config_dir() / "wells" / f"s_shaped_{of}.csv").read_text("utf-8") for of in ("survey", "tally")}
"""Tables of the well s_shaped, whose kernel other tests have."""


def new_well(front, name="north 1", tables=TABLES, **options):
    given = {"--hole": "40 mm", "--wob": "150 N", **options}
    assert front.ask(do="scene new", on=[name], options=given, tables=tables) == ""
    return front.ended()


def test_a_well_from_pasted_tables_to_its_statics_its_run_and_the_opened_report(front):
    made = new_well(front, tables=DEEP, **{"--hole": "12 1/4 in", "--wob": "100 kN"})
    assert made["code"] == 0, made
    assert made["line"] == (
        "drill-twin scene new north_1.yaml '--hole=12 1/4 in' '--wob=100 kN' --survey=north_1_survey.csv "
        "--tally=north_1_tally.csv"
    )
    assert "north_1.yaml: 3000 m, 5 sections" in made["text"]
    assert load_scene(front.folder / "north_1.yaml").rig.weight_on_bit.value == pytest.approx(100e3)

    assert front.ask(do="statics", on=["north_1.yaml"]) == ""
    statics = front.ended()
    assert (statics["code"], statics["line"]) == (0, "drill-twin statics north_1.yaml --out=out/statics_north_1")
    assert "hookload" in statics["text"]
    status, headers, content = front.file("out/statics_north_1/statics.png")
    assert (status, headers["Content-Type"].partition(";")[0], content[:4]) == (200, "image/png", b"\x89PNG")

    assert front.ask(do="run", on=["north_1.yaml"], options={"--duration": "0.2 s", "--report": True}) == ""
    run = front.ended()
    assert (run["code"], run["out"]) == (0, "out/run_north_1"), run
    status, headers, content = front.file("out/run_north_1/report.html")
    assert (status, headers["Content-Type"]) == (200, "text/html; charset=utf-8")
    assert b"<title>north_1: drill_twin report</title>" in content
    assert headers.get_all("Content-Security-Policy")[0].startswith(
        "sandbox allow-scripts allow-downloads; default-src"
    )
    assert len(headers.get_all("Content-Security-Policy")) == 1

    def listed():
        with front.client() as client:
            while "results" not in (said := json.loads(client.recv(timeout=30.0))):
                pass
        return {one["name"]: one for one in said["results"]} if len(said["results"]) == 2 else None

    results = front.until(listed)
    assert list(results) == ["out/run_north_1", "out/statics_north_1"]  # the newest first
    assert results["out/run_north_1"]["bag"]
    assert results["out/run_north_1"]["files"][0] == "report.html"
    assert results["out/statics_north_1"]["files"] == ["statics.png", "statics.json", "statics.csv"]


def test_field_units_are_those_of_the_tables_and_of_the_scene(front):
    survey, tally = "md,inc,azi\n0,0,0\n3000,0,0\n", "kind,length,od,id\ncollar,300,8,2.8125\ndrill pipe,2700,5,4.276\n"
    tables = {"--survey": survey, "--tally": tally}
    made = new_well(front, tables=tables, **{"--hole": "12 1/4 in", "--wob": "25 klbf", "--units": "field"})
    assert made["code"] == 0, made
    scene = load_scene(front.folder / "north_1.yaml")
    assert (scene.unit_system.length, scene.length) == ("ft", pytest.approx(914.4))


def test_a_wrong_survey_shows_what_the_command_says_and_the_next_try_keeps_the_name(front):
    wrong = new_well(front, tables={**TABLES, "--survey": "md,inc\n0,0\n"})
    assert wrong["code"] == 2
    assert wrong["text"].startswith(
        "drill-twin: error: north_1_survey.csv, line 1: expected the columns md, inclination"
    )
    right = new_well(front)
    assert right["code"] == 0, right
    assert "scene new north_1.yaml" in right["line"]
    assert "--survey=north_1_survey_2.csv --tally=north_1_tally.csv" in right["line"]  # the tally is kept already
    assert (front.folder / "north_1_survey.csv").read_text("utf-8") == "md,inc\n0,0\n"
    again = new_well(front)
    assert (again["code"], (front.folder / "north_1_2.yaml").exists()) == (0, True)  # no scene is overwritten
    assert sorted(file.name for file in front.folder.glob("*.csv")) == [
        "north_1_survey.csv", "north_1_survey_2.csv", "north_1_tally.csv",
    ]  # fmt: skip


def gone(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.long
def test_two_commands_at_a_time_a_third_is_refused_and_stop_keeps_the_bag(front):
    long = {"do": "run", "on": ["pa6_bench"], "options": {"--duration": "100000 s"}}
    assert front.ask(**long) == ""
    assert front.ask(**long) == ""
    assert front.ask(**long) == "expected at most 2 commands at a time, found more; stop a command, or wait"
    second, first = front.commands()
    assert (first["out"], second["out"]) == ("out/run_pa6_bench", "out/run_pa6_bench_2")
    front.until(lambda: " left" in front.commands()[1]["text"])  # its output comes while it runs
    assert front.ask(stop=first["number"]) == ""
    ended = front.until(lambda: (job := front.commands()[1])["code"] is not None and job)
    assert ended["code"] == 128 + signal.SIGTERM
    assert "the bag is whole up to there: out/run_pa6_bench/bag_0" in ended["text"]
    assert list((front.folder / "out" / "run_pa6_bench" / "bag_0").glob("*.mcap"))
    assert front.ask(stop=first["number"]) == ""  # it has ended: nothing is done

    assert front.ask(do="watch", on=["out/run_pa6_bench"]) == ""  # a page of its own, beside the run
    page = front.until(lambda: (job := front.commands()[0])["text"] and job)
    assert page["line"] == "drill-twin watch out/run_pa6_bench --port=0 --no-browser --host=127.0.0.1"
    place = re.match(r"out/run_pa6_bench at http://(127\.0\.0\.1:\d+)/#code=", page["text"])[1]
    assert b"String in the hole" in get(place, "/")[1]
    front.server.close()
    until(lambda: gone(page["number"]) and gone(second["number"]), "the end of both", 60.0)
