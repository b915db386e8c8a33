# SPDX-License-Identifier: Apache-2.0
"""Plans drawn at random agree with sums by hand, and the comparison sees a friction that is a twentieth off."""

from pathlib import Path

import pytest
import typer

from drill_twin_evidence.validation import drawn_commands, drawn_plans


@pytest.mark.parametrize(
    "number", [1, 81, pytest.param(3, marks=pytest.mark.long), pytest.param(4, marks=pytest.mark.long)]
)
def test_a_drawn_plan_agrees_with_sums_by_hand(number):
    assert drawn_plans.drawn(number).agrees


def test_the_comparison_sees_another_friction(tmp_path):
    plans = (drawn_plans.plan(number, tmp_path) for number in range(1, 50))
    scene = next(scene for scene, _ in (plan.scene() for plan in plans) if scene.hole.survey)
    wall = scene.effects.wall_friction
    more = wall.model_copy(update={
        "coefficient": 1.05 * wall.coefficient,
        "intervals": tuple(one.model_copy(update={"coefficient": 1.05 * one.coefficient}) for one in wall.intervals),
    })  # fmt: skip
    other = scene.model_copy(update={"effects": scene.effects.model_copy(update={"wall_friction": more})})
    (hookload, torque), (same, larger) = drawn_plans.sums(scene), drawn_plans.sums(other)
    assert same == hookload
    assert larger == pytest.approx(1.05 * torque)
    assert larger > torque * (1.0 + drawn_plans.CLOSE)


def test_the_trial_of_commands_counts_what_fails(tmp_path: Path, monkeypatch, capsys):
    broken = typer.Typer()

    @broken.command()
    def scene(_act: str, _file: str, _more: str) -> None:
        print("torque nan N m")
        raise ZeroDivisionError

    tried = drawn_commands.Tried()
    tried.command(1, ["scene", "check", "SCENE"], Path("two_mass"), tmp_path)
    assert tried == {"scene": 1}
    tried.command(1, ["scene", "check", "SCENE"], tmp_path / "none.yaml", tmp_path)
    assert tried["scene check, refused"] == 1
    monkeypatch.setattr(drawn_commands, "app", broken)
    tried.command(1, ["scene", "check", "SCENE"], Path("two_mass"), tmp_path)
    assert tried["scene check, traceback"] == tried["scene check, nan"] == 1
    assert "ZeroDivisionError" in capsys.readouterr().out
