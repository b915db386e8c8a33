# SPDX-License-Identifier: Apache-2.0
"""Cases beside each other: what differs, in the table, the data and the page of `drill-twin compare`."""

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.api.compare import prepare, settled
from drill_twin.api.compared_quantities import Case, ComparedQuantity, quantities
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError
from drill_twin.core.units.system import SYSTEMS

SOON = ["--set", "rig.weight_on_bit.duration=0.3 s", "--set", "rig.rotation.duration=0.3 s"]
HEAVIER = "pa6_bench,wob=60 N,effects.wall_friction.coefficient=0.1"


@pytest.mark.parametrize(
    ("values", "differs"),
    [
        ((1.0, 1.04), False), ((1.0, 1.06), True), ((1.0, 1.0, 0.9), True), ((0.0, 1e-12), False), ((-1.0, 1.0), True),
        ((math.nan, 1.0), True), ((math.nan, math.nan), False), (("forward whirl", "irregular"), True),
        (("at rest", "at rest"), False),
    ],
)  # fmt: skip
def test_what_differs(values: tuple[float | str, ...], differs: bool) -> None:
    assert ComparedQuantity("speed", "m", values).differs(0.05) is differs


def test_numbers_are_shown_with_their_difference() -> None:
    force = ComparedQuantity("force", "N", (8e3, 1e4, math.nan))
    assert [force.text(case, SYSTEMS["si"]) for case in range(3)] == ["8", "10 (+25 %)", "none"]
    assert ComparedQuantity("stress", "Pa", (2e6, 1e6)).text(1, SYSTEMS["si"]) == "1 (-50 %)"


def test_a_case_is_a_scene_with_changes_or_a_bag(tmp_path: Path) -> None:
    scene = prepare(HEAVIER, {"rig.duration": "2 s"})
    assert (scene.rig.weight_on_bit.value, scene.effects.wall_friction.coefficient, scene.rig.duration) == (
        60.0,
        0.1,
        2.0,
    )
    table = prepare("pa6_bench,rpm=90 rpm", {})
    assert table.rig.rotation.value == pytest.approx(3.0 * math.pi)
    with pytest.raises(ArgumentError, match="a bag without changes"):
        prepare(f"{tmp_path},wob=3 N", {})


def test_the_command_compares_a_run_with_a_bag(tmp_path: Path) -> None:
    soon = {"rig.weight_on_bit.duration": 0.3, "rig.rotation.duration": 0.3}
    bag = dt.Simulation("pa6_bench", soon).run(duration=1.0).to_bag(tmp_path / "bag_0")
    out = tmp_path / "out"
    arguments = ["compare", str(bag), HEAVIER, "--duration", "1", "--out", str(out), *SOON]
    said = CliRunner().invoke(app, arguments)
    assert said.exit_code == 0, said.output
    assert f"B: {HEAVIER}" in said.stdout
    data = json.loads((out / "compare.json").read_text())
    found = {row["name"]: row for row in data["quantities"]}
    first, second = found["weight on bit, mean"]["values"]
    assert second == pytest.approx(1.5 * first, rel=1e-6)
    assert found["weight on bit, mean"]["differs"]
    assert not found["speed of the bit, largest"]["differs"]
    hookload = found["balance, drill: hookload"]["values"]
    assert hookload[0] - hookload[1] == pytest.approx(20.0, rel=1e-3)
    page = (out / "compare.html").read_text()
    assert page.index("weight on bit, mean") < page.index("What does not") < page.index("speed of the bit, largest")
    assert "data:image/png" in page


def test_a_run_beside_itself_does_not_differ() -> None:
    result = dt.Simulation("pa6_bench").run(duration=0.5)
    rows = quantities([Case("one", result, None), Case("other", result, None)])
    assert len(rows) > 10
    assert not any(row.differs(0.0) for row in rows)


def test_one_case_is_refused() -> None:
    assert "two cases or more" in str(CliRunner().invoke(app, ["compare", "pa6_bench"]).exception)
