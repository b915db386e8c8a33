# SPDX-License-Identifier: Apache-2.0
"""Cases beside each other: what differs, in the table, the data and the page of `drill-twin compare`."""

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.api.compare import prepare, settled
from drill_twin.api.compared_quantities import Case, ComparedQuantity, matters, quantities
from drill_twin.api.verdict import costs, verdicts
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


@pytest.mark.long
def test_a_mirrored_run_is_the_same_run() -> None:
    """Torque and speed of a string that turns to the left are those of one that turns to the right."""
    cases = []
    for turns in ("60 rpm", "-60 rpm"):
        scene = dt.load_scene("two_mass", {"rpm": turns, "numerics.step": "20 ms", "numerics.frame_rate": 10.0})
        cases.append(Case(turns, dt.Simulation(scene).run(duration=12.0), dt.statics(scene)["drill"]))
    rows = {row.name: row for row in quantities(cases)}
    assert rows["speed of the bit, largest"].values[1] > 1.0
    assert rows["balance, drill: surface torque"].values[1] > 1e3
    assert [name for name, row in rows.items() if row.differs(0.01)] == []


def test_a_case_that_turns_to_the_left_has_a_note_and_its_loads(tmp_path: Path) -> None:
    data = yaml.safe_load(dt.load_scene("two_mass").to_yaml())
    data["string"]["sections"][0]["make_up_torque"] = "30 kN m"
    (tmp_path / "pipe.yaml").write_text(yaml.safe_dump(data))
    fast = ["--repeats", "1", "--duration", "1", "--set", "numerics.step=20 ms", "--set", "numerics.frame_rate=10 Hz"]
    cases = [str(tmp_path / "pipe.yaml"), f"{tmp_path / 'pipe.yaml'},rpm=-60 rpm"]
    said = CliRunner().invoke(app, ["compare", *cases, "--out", str(tmp_path / "out"), *fast])
    assert said.exit_code == 0, said.output
    found = json.loads((tmp_path / "out" / "compare.json").read_text())
    (note,) = (note for note in found["notes"] if "to the left" in note)
    assert note.endswith(
        "rpm=-60 rpm turns to the left: right-hand joints can back off, at a torque not computed here."
    )
    assert "balance, drill: hookload" in {row["name"] for row in found["quantities"]}


def contact(name: str, place: float, force: float, build: float = math.nan) -> SimpleNamespace:
    return SimpleNamespace(name=name, distance_from_bit=place, force=force, build=build)


def assembly(result: dt.Result, *blades: SimpleNamespace, build: float = math.nan, margin: float = 3.0) -> Case:
    """A case with blades at places, forces [N], and a signed side force at the bit."""
    loads = SimpleNamespace(
        operation=SimpleNamespace(name="drill"), hookload=1e5, surface_torque=1e3, neutral_point=9.0,
        margins=(2.0, 2.0), yield_margin=3.0, make_up_margin=margin,
        contacts=(contact("bit", 0.0, abs(build), build), *blades),
    )  # fmt: skip
    return Case("case", result, loads)


def test_contacts_are_paired_by_place_and_a_doubled_force_of_the_wall_is_seen() -> None:
    result = dt.Simulation("pa6_bench").run(duration=0.5)
    near = assembly(result, contact("stabiliser", 0.5, 3e3))
    far = assembly(result, contact("stabiliser", 2.5, 6.3e3))
    other = assembly(result, contact("near-bit stabiliser", 0.52, 6e3))
    rows = {row.name: row for row in quantities([near, far, other])}
    beside = rows["balance, drill: side force, stabiliser, 0.5 m from the bit"]
    assert beside.values[0] == 3e3
    assert math.isnan(beside.values[1])
    assert beside.values[2] == 6e3  # another name at the same place
    assert rows["balance, drill: side force, stabiliser, 2.5 m from the bit"].values[1] == 6.3e3
    found = costs([[near, other], [near, replace(other)]], 0.05)
    assert next(cost for cost in found if cost.name == "largest side force of a stabiliser").matters == 550.0
    assert rows["balance, drill: largest side force of a stabiliser"].differs(0.05)


def test_the_side_force_at_the_bit_has_a_sign() -> None:
    result = dt.Simulation("pa6_bench").run(duration=0.5)
    said = verdicts([], SYSTEMS["field"], [assembly(result, build=-667.2), assembly(result, build=222.4)])
    assert said[-1] == "side force at the bit: A -0.15 klbf (drop), B +0.05 klbf (build)"
    assert "neither build nor drop" in verdicts([], SYSTEMS["field"], [assembly(result)])[-1]
    row = next(row for row in quantities([assembly(result, build=-667.2), assembly(result, build=222.4)])
               if row.name.endswith("side force at the bit, + build, - drop"))  # fmt: skip
    assert row.values == (-667.2, 222.4)
    assert row.differs(0.05)


@pytest.mark.parametrize(
    ("values", "differs"), [((0.42, 0.46), False), ((0.1, 2.0), True), ((20.0, 20.9), False), ((20.0, 22.0), True)]
)
def test_a_difference_below_what_matters_is_none(values: tuple[float, ...], differs: bool) -> None:
    """0.0428 against 0.0464 g is significant, and matters to nobody."""
    least, _ = matters("axial acceleration, rms", Case("one", dt.Simulation("pa6_bench").run(duration=0.1), None))
    assert least == pytest.approx(0.125 * 9.80665)
    assert ComparedQuantity("axial acceleration, rms", "m/s^2", values, least).differs(0.05) is differs


@pytest.mark.parametrize(("values", "differs"), [((22.5, 16.5), False), ((2.5, 1.6), True), ((1.6, 1.55), False)])
def test_a_margin_matters_near_its_limit_only(values: tuple[float, ...], differs: bool) -> None:
    result = dt.Simulation("pa6_bench").run(duration=0.1)
    cases = [assembly(result, contact("stabiliser", 0.5, 3e3), margin=margin) for margin in values]
    row = next(row for row in quantities(cases) if row.name.endswith("make-up margin"))
    assert row.differs(0.01) is differs
    again = [replace(case) for case in cases]
    ranked = {cost.name: cost.better for cost in costs([cases, again], 0.01)}
    assert ranked["make-up margin"] == (("A",) if differs else ("",))


def test_bounds_of_the_scene_say_what_matters() -> None:
    own = {"severity.source": "a bench", "severity.axial_rms": [0.1, 0.2, 0.3, 0.4]}
    case = Case("one", dt.Simulation("pa6_bench", own).run(duration=0.1), None)
    assert matters("axial acceleration, rms", case)[0] == pytest.approx(0.025)


def test_runs_whose_set_points_still_move_are_prolonged_or_refused() -> None:
    scenes = [prepare("pa6_bench", {"duration": "5 s"}), prepare("pa6_bench,rig.duration=30 s", {})]
    longer, notes = settled(scenes)
    assert [scene.rig.duration for scene in longer] == [17.2, 30.0]
    assert notes == ["Set-points settle at 8.6 s: the runs were prolonged to 17.2 s."]
    assert settled(scenes[1:]) == (scenes[1:], [])
    with pytest.raises(ArgumentError, match=r"its set-points have settled at 8\.6 s, found one of 0\.5 s"):
        settled([dt.Simulation("pa6_bench").run(duration=0.5), scenes[1]])


def test_one_case_is_refused() -> None:
    assert "two cases or more" in str(CliRunner().invoke(app, ["compare", "pa6_bench"]).exception)
