# SPDX-License-Identifier: Apache-2.0
"""The frame of the exact checks: a wrong twin misses, and the command says so."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drill_twin.cli.app import app
from drill_twin.core.files.plain_json import json_text
from drill_twin_evidence.cli import output
from drill_twin_evidence.verify import Case, Row, all_cases, choose, run, scenes
from drill_twin_evidence.verify.page import summary, to_page
from drill_twin_evidence.verify.row import TWIN
from drill_twin_evidence.verify.run import CaseResult, run_cases
from drill_twin_evidence.verify.statics.airy import critical_bit_load

QUICK = "lateral_frequencies.frequencies[free,lateral]"

RECORD = json.loads((Path(__file__).resolve().parents[2] / "pages" / "verification.json").read_text("utf-8"))


def row(computed: float, **fields: object) -> Row:
    return Row(**({"what": "load [N]", "reference": "F | G", "source": "Euler", "expected": -2.0, "computed": computed,
                   "tolerance": 1e-3} | fields))  # fmt: skip


def test_a_row_holds_within_its_tolerance() -> None:
    assert row(-2.001).ok
    assert row(-2.001).error == pytest.approx(-5e-4)
    assert not row(-2.003).ok
    assert row(-2.0009, relative=False).ok
    assert not row(-2.0015, relative=False).ok
    assert not row(math.nan).ok
    assert json.loads(json_text(row(math.nan).to_dict()))["computed"] is None
    with pytest.raises(ValueError, match="relative=False"):
        row(1.0, expected=0.0)


def test_names_are_unique_and_chosen_by_pattern() -> None:
    names = [case.name for case in all_cases()]
    assert len(set(names)) == len(names) > 50
    assert [case.name for case in choose(QUICK)] == [QUICK]
    assert {case.form for case in choose("buckling.*lateral]")} == {"lateral"}
    assert not choose("no such")
    assert not any(case.long for case in choose(quick=True))
    assert all(case.about for case in all_cases())


@pytest.mark.parametrize("name", [QUICK, "statics.stretch_under_its_own_weight[spatial]", "waves.torsional[spatial]"])
def test_a_softer_rod_is_found_out(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two per cent less of Young's modulus in the scene, not in the formula."""
    monkeypatch.setattr(scenes, "YOUNG", 0.98 * scenes.YOUNG)
    assert not all(row.ok for row in choose(name)[0].run())


def test_the_heavy_string_of_the_literature() -> None:
    """Weight on bit over w (EI / w)^(1/3), clamped at the top, 10 units long: the digits of an independent solution."""
    assert critical_bit_load(1.0, 1.0, 10.0, "guided") == pytest.approx(3.408, abs=1e-3)
    assert critical_bit_load(1.0, 1.0, 10.0, "pinned") == pytest.approx(1.881, abs=1e-3)


def invoke(*arguments: str) -> object:
    return CliRunner().invoke(app, ["study", "verify", *arguments])


def test_the_command_runs_cases_and_writes_the_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    said = invoke("--only", QUICK, "--workers", "1", "--json", "--page", str(page))
    assert said.exit_code == 0, said.output
    found = json.loads(said.stdout)
    assert found == json.loads(page.with_suffix(".json").read_text("utf-8"))
    assert found["ok"] is True
    assert [case["case"] for case in found["cases"]] == [QUICK]
    assert len(found["cases"][0]["rows"]) == 3
    text = page.read_text("utf-8")
    assert "3 of 3 numbers beside formulas, zeros and tables, of 1 cases, are within their tolerance." in text
    assert f"drill-twin study verify --only {QUICK} --page {page.as_posix()}" in text
    assert "Blevins 1979" in text
    assert "## Not validated" in text


def test_the_command_lists_names() -> None:
    said = invoke("--list", "--only", "waves.")
    assert said.exit_code == 0
    assert "waves.axial" in said.stdout
    assert "lateral.frequencies" not in said.stdout


@pytest.fixture
def check() -> Callable[..., CaseResult]:
    def make(*rows: Row, failure: str = "") -> CaseResult:
        return CaseResult(choose(QUICK)[0], rows, 0.1, failure)

    return make


def test_the_twin_beside_itself_is_counted_apart(check: Callable[..., CaseResult]) -> None:
    own = Row("hookload [N]", "balance", f"{TWIN}drill-twin statics", 1.0, 1.0, 0.1)
    said = summary([check(row(-2.0), own, replace(own, computed=2.0))])
    assert said.startswith(
        "1 of 1 numbers beside formulas, zeros and tables and 1 of 2 of the twin beside itself, of 1"
    )
    assert [one["consistency"] for one in check(row(-2.0), own).to_dict()["rows"]] == [False, True]
    sources = {line["source"] for case in RECORD["cases"] for line in case["rows"] if line["consistency"]}
    assert {source.removeprefix(TWIN) for source in sources} >= {
        "drill-twin statics", "the other formulation", "the time loop", "a run with more elements"
    }  # fmt: skip


def test_a_miss_ends_with_one(check: Callable[..., CaseResult], monkeypatch: pytest.MonkeyPatch) -> None:
    for missed in (check(row(-2.0), row(-3.0)), check(failure="RunError: no step"), check()):
        monkeypatch.setattr(run, "run_cases", lambda *_, missed=missed, **__: [missed])
        said = invoke("--only", QUICK)
        assert said.exit_code == 1
        assert "**miss**" in to_page([missed], "") or not (missed.rows or missed.failure)
    monkeypatch.setattr(run, "run_cases", lambda *_, **__: [check(row(-2.0))])
    assert invoke("--only", QUICK).exit_code == 0


def test_a_pattern_that_fits_nothing_is_an_error() -> None:
    said = invoke("--only", "no such")
    assert said.exit_code != 0
    assert "no such" in str(said.exception)


def test_a_case_that_cannot_run_is_a_miss() -> None:
    found = run_cases([Case("no.such", "no", "both", False, list)], workers=1)
    assert not found[0].ok
    assert "no.such" in found[0].failure


def test_the_page_has_each_reference_and_the_number_nearest_to_its_tolerance(check: Callable[..., CaseResult]) -> None:
    text = to_page([check(row(-2.0001), row(-2.001, what="a | b"), row(-2.0, reference="H"))], "this")
    assert "Reference: `F | G` (Euler); `H` (Euler)." in text
    assert [line for line in text.splitlines() if line.startswith("| lateral")] == [
        "| lateral | 3 | bit end free: a \\| b | -2 | -2.001 | -5.0e-04 | 0.001 | ok |"
    ]
    missed = to_page([check(row(-2.0), row(-3.0), row(-4.0))], "this")
    assert missed.count("**miss**") == 2


def test_the_data_of_a_page_of_the_documentation_are_evidence(tmp_path, monkeypatch):
    monkeypatch.setattr(output, "EVIDENCE", tmp_path / "evidence")
    for folder in ("evidence/docs", "evidence/pages"):
        (tmp_path / folder).mkdir(parents=True)
    for page, data in (("evidence/docs/hard.md", "evidence/pages/hard.json"), ("hard.md", "hard.json")):
        output.write_page(
            tmp_path / page, lambda line: f"by {line}\n", {}, command="hard", only="", flags={"--quick": True}
        )
        assert (
            tmp_path / page
        ).read_text() == f"by drill-twin study hard --quick --page {(tmp_path / page).as_posix()}\n"
        assert (tmp_path / data).read_text() == "{}\n"
    assert not (tmp_path / "evidence" / "docs" / "hard.json").exists()
