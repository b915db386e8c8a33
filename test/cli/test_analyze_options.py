# SPDX-License-Identifier: Apache-2.0
"""`drill-twin analyze` on a part of a bag, and what it says of options that are none."""

import json

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError, BagError


def ran(*arguments):
    return CliRunner().invoke(app, ["analyze", *map(str, arguments)])


def test_marks_and_time(bench_run):
    result = ran(bench_run.bag, "--marks", "mark_3,mark_1", "--from", "1", "--to", "2.5", "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert list(found["mark_motion"]) == ["mark_1", "mark_3"]
    assert found["duration_s"] == 2.5
    assert found["samples"] == 151


def test_a_table_has_no_clearance_of_marks(tmp_path):
    table = tmp_path / "marks.csv"
    rows = "".join(f"{0.1 * k:.1f},120,{0.01 * (k % 3)}\n" for k in range(300))
    table.write_text(f"time [s],RPM [rpm],x [m]\n{rows}")
    result = ran(table, "--clearance", "36 mm")
    assert result.exit_code == 0, result.output
    assert "no marks are read from a table; drill_twin.analyze" in " ".join(result.output.split())
    assert "columns of marks" not in ran(table).output


def test_every_mark_has_its_timeline(bench_run):
    result = ran(bench_run.bag, "--all")
    assert result.exit_code == 0, result.output
    assert all(result.stdout.count(f"mark_{k}") >= 2 for k in range(1, 5))
    assert "what decided it" in result.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--remap", "/marks"), "--remap: expected THEIRS=OURS"),
        (("--remap", "/their/marks=/marks/state"), "expected the topic /their/marks"),
        (("--from", "3", "--to", "2"), "expected a start before the end"),
        (("--clearance", "3 N"), "--clearance: expected a length"),
        (("--marks", "mark_9"), "found mark_9"),
    ],
)
def test_options_that_are_none(bench_run, options, words):
    result = ran(bench_run.bag, *options)
    assert result.exit_code != 0
    assert isinstance(result.exception, (ArgumentError, BagError))
    assert words in str(result.exception)
