# SPDX-License-Identifier: Apache-2.0
"""`drill-twin study paper` writes what it says."""

import json

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.core.errors import BagError, SceneError
from drill_twin_evidence.paper.runs.reproduction import reproduce


def command(*words):
    return CliRunner().invoke(app, [str(word) for word in words], env={"COLUMNS": "200"})


def test_paper_writes_table_page_and_figures(quick_file, tmp_path):
    out = tmp_path / "paper"
    done = command("study", "paper", "--scene", quick_file, "--quick", "--workers", "1", "--out", out)
    assert done.exit_code == 0, done.output
    for words in (
        "published numbers of the bench within 20 %",
        "critical time, 300 N, 2 rev/s",
        "0.89 s",
        "21.63 r/min",
    ):
        assert words in done.output
    data = json.loads((out / "paper.json").read_text())
    assert len(data["numbers"]) == 15
    assert len(data["runs"]) == 15
    assert data["full_size"] == data["variants"] == []
    numbers = {n["q"] + n["what"]: n for n in data["numbers"]}
    runs = {(run["weight_on_bit"], run["speed"]): run for run in data["runs"]}
    assert numbers["Q14critical time"]["ours"] == runs[300.0, 2.0]["onset_s"] is not None
    page = (out / "paper.md").read_text()
    assert "| Q14 | critical time, 300 N, 2 rev/s | 0.89 s |" in page
    assert "name: pa6_calibrated" in page
    for name in ("displacement", "paths", "spectra", "speed", "load", "motion"):
        assert (out / f"paper_{name}.png").stat().st_size > 10_000
        assert f"![paper {name}](paper_{name}.png)" in page
    again = command("study", "paper", "--scene", quick_file, "--quick", "--out", out)
    assert isinstance(again.exception, BagError)
    assert "--replace" in str(again.exception)


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        ("no_such_bench", "no_such_bench"),
        ("two_mass", "expected the paper's marks mark_1, mark_2, mark_3 in string.marks, found"),
    ],
)
def test_a_scene_that_is_no_bench_is_one_clear_error(scene, words, tmp_path):
    done = command("study", "paper", "--scene", scene, "--out", tmp_path / "x")
    assert isinstance(done.exception, SceneError)
    assert words in str(done.exception)
    assert not (tmp_path / "x").exists()


@pytest.mark.long
def test_the_matrix_reproduces_what_the_documentation_says():
    from drill_twin_evidence.paper.runs.reproduction import bench

    done = reproduce(bench(), variants=False, full_size_too=False)
    near = {row.number.name for row in done.rows if row.near}
    right = {trend.published for trend in done.trends if trend.right}
    assert near >= NEAR
    assert right >= RIGHT


NEAR = {
    "critical time, 20 N, 2 rev/s", "critical time, 40 N, 2 rev/s", "whirl frequency, 20 N, 2 rev/s",
    "whirl ratio, 40 N, 2 rev/s", "whirl ratio, 40 N, 3 rev/s", "whirl ratio, 40 N, 6.5 rev/s",
}  # fmt: skip
RIGHT = {
    "critical time falls with speed", "critical time nearly linear in speed", "critical time falls with weight on bit",
    "critical time: steep at first, then flat", "whirl frequency rises with speed",
}  # fmt: skip
