"""The commands of the rotordynamics, and their API."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.core.errors import ArgumentError, SceneError

FORM = ["--set", "effects.stretch=off", "--set", "effects.torsion=off", "--set", "numerics.elements=12"]


def invoke(*arguments):
    return CliRunner().invoke(app, [*arguments, *FORM])


@pytest.mark.slow
def test_modes_as_json_with_its_figures(tmp_path):
    said = invoke(
        "modes", "pa6_bench", "--wob", "5 N", "--campbell", "5", "--growth", "3", "--json", "--out", str(tmp_path)
    )
    assert said.exit_code == 0, said.output
    found = json.loads(said.stdout)
    assert found["weight_on_bit_n"] == 5.0
    assert found["modes"][0]["kind"] == "lateral"
    assert len(found["campbell"]["frequency_hz"]) == 5
    assert np.array(found["growth"]["lateral_growth_per_s"]).shape == (3, 3)
    assert json.loads((tmp_path / "modes.json").read_text()) == found
    assert all((tmp_path / f"{name}.png").stat().st_size > 10_000 for name in ("modes", "campbell", "growth"))


def test_modes_as_a_table():
    said = invoke("modes", "pa6_bench", "--wob", "5 N")
    assert said.exit_code == 0, said.output
    assert "string on the axis" in said.stdout
    assert "backward" in said.stdout


@pytest.mark.slow
def test_the_api_gives_the_numbers_of_the_command(bench):
    table = dt.modes(bench, {"wob": 5.0})
    said = json.loads(invoke("modes", "pa6_bench", "--wob", "5 N", "--json", "--count", "12").stdout)
    assert [mode["frequency_hz"] for mode in said["modes"]] == [mode.frequency for mode in table.modes]
    assert dt.campbell(bench, speeds=[1.0, 2.0]).eigenvalues.shape == (2, 6)
    assert dt.growth_map(bench, weights=[1.0], speeds=[1.0, 2.0]).lateral.shape == (1, 2)
    with pytest.raises(ArgumentError, match=r"weights: expected increasing values, found \[2.0, 1.0\]; sort them"):
        dt.growth_map(bench, weights=[2.0, 1.0], speeds=[1.0])


def test_a_record_has_no_final_set_points(bench):
    turn = bench.rig.rotation.model_copy(update={"shape": "table"})
    recorded = bench.model_copy(update={"rig": bench.rig.model_copy(update={"rotation": turn})})
    with pytest.raises(
        SceneError, match=r"found a recorded rotation, which changes; --set rig.rotation.shape=constant"
    ):
        dt.modes(recorded)
