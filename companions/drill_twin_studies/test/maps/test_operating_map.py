# SPDX-License-Identifier: Apache-2.0
"""A map is what its runs say, goes on where it was broken off, and is refused for another scene."""

import csv
import io
import json
import math
import resource
import shlex

import numpy as np
import pytest
from coarse_map import ASKED, COARSE

import drill_twin as dt
from drill_twin.core.errors import ArgumentError, BagError, SceneError
from drill_twin.core.files.plain_json import json_text
from drill_twin.io.messages.topic_words import digest_of
from drill_twin_studies.maps.operating_map import OperatingMap

ALL = {regime.value for regime in dt.Regime}


@pytest.mark.slow
def test_it_has_both_boundaries_and_knows_its_regimes(found):
    regimes = {record.regime.value for record in found.records.values()}
    assert {"smooth", "forward whirl"} <= regimes <= ALL
    assert 0 < found.whirls.sum() < found.whirls.size
    assert (found.keeps_whirling >= found.whirls).all()
    assert found.has_second_boundary
    assert found.regime(2.0, 2 * math.tau) is dt.Regime.SMOOTH
    assert found.regime(40.0, 2 * math.tau) is dt.Regime.FORWARD
    assert found.regime("2 N", "120 rpm") is dt.Regime.SMOOTH
    assert found.margin("40 N", "2 rev/s") == found.margin(40.0, 2 * math.tau)
    with pytest.raises(dt.DrillTwinError, match=r'weight: expected a force such as .*, found "40" \(no unit\)'):
        found.regime("40", "2 rev/s")


def test_each_run_is_repeated_by_its_command(found):
    """From rest and from a whirl: the values of the command line give the onset of the map."""
    for falling in (False, True):
        key = next(
            key
            for key, record in found.records.items()
            if record.whirls and (key.origin is not None) == falling and key.draw == 0
        )
        words = shlex.split(found.command_of(key, "pa6_bench"))
        assert words[:3] == ["drill-twin", "run", "pa6_bench"]
        changes = dict(word.split("=", 1) for word in words if "=" in word)
        result = dt.Simulation("pa6_bench", {**COARSE, **changes}).run(duration=float(words[-1]))
        assert result.onset_s == found.records[key].onset_s


def test_draws_take_the_scene_first_and_fill_their_ranges(found):
    assert found.draws[0]["effects.wall_friction.coefficient"] == 0.205
    later = [draw["effects.wall_friction.coefficient"] for draw in found.draws[1:]]
    assert all(0.1 <= value <= 0.3 for value in later)
    assert 1e-5 <= found.draws[1]["effects.bow.amplitude"] <= 2e-4
    assert any(0 < sum(run.whirls for run in runs) < len(runs) for runs in found.runs_at_nodes.values())


OUTER, INNER = "string.sections.0.outer_diameter", "string.sections.0.inner_diameter"


def test_draws_that_do_not_fit_together_are_left_out_and_counted():
    """A bore may be wider than a pipe though each range alone fits the scene."""
    asked = {**ASKED, "seeds": 9, "vary": {OUTER: "10..17 mm", INNER: "1..16 mm"}, "hysteresis": False, "runs": 1}
    found = dt.operating_map("pa6_bench", COARSE, **asked)
    assert 2 <= len(found.draws) < 9
    assert all(draw[INNER] < draw[OUTER] for draw in found.draws)
    assert f"{9 - len(found.draws)} of 9 draws left out: the scene does not take their numbers together" in found.notes
    assert [draw["numerics.seed"] for draw in found.draws] != list(range(1, len(found.draws) + 1))


def test_margins_are_those_of_the_calm_nodes(found):
    weight, speed = 1.0, 2.0 * math.tau
    margin = found.margin(weight, speed)
    assert margin.share > 0.0
    assert found.calm[found.node(weight + 0.9 * margin.weight, speed)]
    assert not found.calm[found.node(weight + margin.weight + 0.6 * 39.0 / 8.0, speed)]
    assert found.margin(40.0, speed).share < 0.0
    with pytest.raises(ArgumentError, match=r"1 to 40 N and 0\.5 to 3 rev/s, found 41 N"):
        found.margin(41.0, speed)


def test_a_map_that_was_broken_off_ends_with_the_same_bits(found, place, tmp_path):
    lines = (place / "runs.jsonl").read_bytes().splitlines(keepends=True)
    (tmp_path / "runs.jsonl").write_bytes(b"".join(lines[: len(lines) * 15 // 16]) + lines[-1][:40])
    ended = []
    again = dt.operating_map(
        "pa6_bench", COARSE, folder=tmp_path, progress=lambda *said: ended.append(said), workers=1, **ASKED
    )
    assert json_text(again.to_dict()) == json_text(found.to_dict())
    assert sorted((tmp_path / "runs.jsonl").read_bytes().splitlines()) == sorted(line.strip() for line in lines)
    assert 0 < len(ended) < len(found.records) / 4
    assert all(done <= expected for _, done, expected in ended)


def test_the_file_says_all_and_is_read_back(found, tmp_path):
    file = tmp_path / "map.json"
    file.write_text(json_text(found.to_dict()))
    again = dt.read_map(file)
    assert again.to_dict() == found.to_dict()
    assert np.array_equal(again.regimes, found.regimes)
    rows = list(csv.DictReader(io.StringIO(found.csv())))
    assert len(rows) == len(found.records)
    assert {row["regime"] for row in rows} == {record.regime.value for record in found.records.values()}


@pytest.mark.parametrize(
    "text", ["{}", "[1, 2]", "no map", '{"map": null}', "[" * 100_000, '{"format": 1, "weight_on_bit_N": [1]}']
)
def test_another_file_is_no_map(tmp_path, text):
    file = tmp_path / "map.json"
    file.write_text(text)
    with pytest.raises(ArgumentError, match=r"map\.json: expected the map\.json of `drill-twin map`"):
        dt.read_map(file)


@pytest.mark.parametrize("changes", [
    {"origin": []}, {"origin": [1]}, {"node": [0]}, {"node": None}, {"draw": "x"}, {"node": [0, 1e400]}, {"regime": []},
])  # fmt: skip
def test_a_map_with_an_odd_run_is_refused(found, tmp_path, changes):
    data = json.loads(json_text(found.to_dict()))
    data["runs"][0] |= changes
    file = tmp_path / "map.json"
    file.write_text(json.dumps(data))
    with pytest.raises(ArgumentError, match=r"map\.json: expected the map\.json of `drill-twin map`"):
        dt.read_map(file)


def test_a_map_belongs_to_the_numbers_of_its_scene(found):
    same = dt.load_scene("pa6_bench", {"wob": 17, "rpm": 240, "numerics.elements": 30, "duration": 7})
    found.check_scene(same)
    other = dt.load_scene("pa6_bench", {"effects.wall_friction.coefficient": 0.3})
    assert digest_of(other) != digest_of(same)
    with pytest.raises(ArgumentError, match="expected a map of pa6_bench, found a map of pa6_bench with other numbers"):
        found.check_scene(other)


def test_a_folder_has_the_runs_of_one_map(place):
    with pytest.raises(ArgumentError, match="results of another range of the weight on bit; choose another folder"):
        dt.operating_map("pa6_bench", COARSE, folder=place, **{**ASKED, "wob": "1..50 N"})
    with pytest.raises(ArgumentError, match="found results of another scene"):
        dt.operating_map("pa6_bench", {**COARSE, "effects.bow.amplitude": 1e-4}, folder=place, **ASKED)


@pytest.mark.slow
def test_a_full_disk_is_told_and_the_map_goes_on(tmp_path):
    """Files of this process may not grow beyond 8 kB."""
    asked = {**ASKED, "seeds": 1, "vary": None, "hysteresis": False, "runs": 44}
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, limits[1]))
    try:
        with pytest.raises(BagError, match=r"runs\.jsonl: expected a place to write the results, found File too large"):
            dt.operating_map("pa6_bench", COARSE, folder=tmp_path, **asked)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    mended = dt.operating_map("pa6_bench", COARSE, folder=tmp_path, **asked)
    assert mended.records == dt.operating_map("pa6_bench", COARSE, **asked).records
    assert any("stopped at 44 runs" in note for note in mended.notes)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"wob": "40 N"},
            'wob: expected LO..HI or LO..HI:N with LO below HI and a unit, such as "1..300 N", found "40 N"',
        ),
        ({"rpm": "-180..-60"}, 'rpm: expected speeds from 0 upwards, found "-180..-60"'),
        ({"wob": "300..1 N"}, "wob: expected LO..HI"),
        ({"rpm": "1..6.5 N"}, "expected a speed of rotation"),
        ({"rpm": "nan..2"}, "rpm: "),
        ({"seeds": 0}, "seeds: expected 1 to 1000, found 0"),
        ({"seeds": 1}, "vary: expected 2 or more seeds"),
        ({"vary": {"gravity.nothing": "1..2"}}, "effects.gravity.nothing: expected one of the keys magnitude"),
        ({"vary": {"wall_friction.coefficient": "0.3..0.1"}}, "expected LO..HI or LO..HI:N with LO below HI"),
        (
            {"vary": {OUTER: "10..10.1 mm", INNER: "16..16.4 mm"}},
            "ranges: expected numbers that fit together, found none in 1 draws",
        ),
        ({"runs": 0}, "runs: expected 1 to 1000000, found 0"),
        ({"duration": -1.0}, "duration: expected a time above 0 s"),
        ({"wob": "1..1e12 N"}, "rig.weight_on_bit.value"),
    ],
)
def test_bad_input_is_one_clear_sentence(change, said):
    with pytest.raises((ArgumentError, SceneError)) as refused:
        dt.operating_map("pa6_bench", COARSE, **{**ASKED, **change})
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_record_and_a_string_without_marks_are_refused():
    with pytest.raises(SceneError, match="expected set-points with a final value, found a recorded weight_on_bit"):
        dt.operating_map("ufrj_rig", wob="1..2 kN", rpm="60..120")
    block = {"rig.weight_on_bit": "{at: block}", "rig.block": "{value: -0.01 m/s, shape: constant}"}
    with pytest.raises(ArgumentError, match="expected a load as set-point, found a block moved by its speed"):
        dt.operating_map(dt.load_scene("pa6_bench", block), wob="1..2 N", rpm="60..120")
    bare = dt.load_scene("pa6_bench")
    bare = bare.model_copy(update={"string": bare.string.model_copy(update={"marks": []})})
    with pytest.raises(SceneError, match="expected marks on the string"):
        dt.operating_map(bare, wob="1..2 N", rpm="60..120")


def test_a_node_outside_the_lattice_is_refused(found):
    data = json.loads(json_text(found.to_dict()))
    data["runs"][0]["node"] = [99, 0]
    with pytest.raises(ArgumentError, match=r"runs\[0\]: expected a node of the lattice and a draw, found Key\(i=99"):
        OperatingMap.from_json(json.dumps(data).encode())
