# SPDX-License-Identifier: Apache-2.0
"""A map.json with one value altered, as by hand or another program, is used as it stands or refused by its field."""

import copy
import json
import math
import re

import pytest
from coarse_map import COARSE

import drill_twin as dt
from drill_twin.core.errors import ArgumentError
from drill_twin.core.files.plain_json import json_text
from drill_twin_studies.maps.advice import Adviser
from drill_twin_studies.maps.drawing import page_data

ODD = [None, "", "x", -1, 0, 0.5, 1e15, -1e308, 10**400, math.nan, math.inf, True, [], [1], [[]], {}, {"x": 1}]
MISSING = object()
NAMED = {"weight_on_bit_N": "weight.on.bit", "rotation_rad_s": "rotation|speed"}
OF_PEOPLE = {"scene_name", "digest", "notes"}  # any text is one
NOT_READ = {"regimes", "safe_windows", "windows_rest_on", "onset_boundary", "end_of_whirl_boundary"}


@pytest.fixture(scope="module")
def data():
    """A map with growth, draws and a whirl that dies, as read from its file."""
    made = dt.operating_map(
        "pa6_bench", COARSE, wob="1..40 N", rpm="30..180", duration=2.0, steps=8, seeds=2, runs=24, workers=1,
    )  # fmt: skip
    assert len(made.growth)
    return json.loads(json_text(made.to_dict()))


def places(value, path=()):
    """Paths of all values; of a list, paths of its last item."""
    yield path
    if isinstance(value, dict):
        for name, item in value.items():
            yield from places(item, (*path, name))
    elif isinstance(value, list) and value:
        yield from places(value[-1], (*path, len(value) - 1))


def altered(data, path, value):
    """Copy of the data with another value at a path, or none."""
    changed = copy.deepcopy(data)
    within = changed
    for part in path[:-1]:
        within = within[part]
    if value is MISSING:
        del within[path[-1]]
    else:
        within[path[-1]] = value
    return changed


def used(found):
    """Do with a map all that advisor, page and command do."""
    adviser = Adviser(found)
    (low, high), (slow, fast) = found.plane.weight, found.plane.speed
    for weight, speed in ((low, slow), (high, fast), (0.5 * (low + high), 0.5 * (slow + fast)), (2.0 * high, -fast)):
        for whirls in (False, True):
            assert adviser.advise(weight, speed, whirls=whirls, seconds=1.0).text
    json_text(found.to_dict())
    json_text(page_data(found, "pa6_bench"))
    assert found.csv()
    assert [found.command_of(key, "pa6_bench") for key in found.records]
    assert all(isinstance(text, str) for text in (found.said_runs, *found.basis, *map(str, found.windows)))


FIELDS = (
    "growth", "torsional_growth", "runs", "draws", "notes", "scene", "steps", "format", "digest", "scene_name",
    "duration_s", "calm_for_s", "clean_checks", "weight_on_bit_N", "rotation_rad_s", *sorted(NOT_READ),
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("field", [*FIELDS[:2], *(pytest.param(field, marks=pytest.mark.long) for field in FIELDS[2:])])
def test_each_value_altered_is_used_or_refused_by_the_name_of_its_field(data, tmp_path, field):
    file, refused, accepted = tmp_path / "map.json", [], []
    for path in places(data[field], (field,)):
        for value in [*ODD, MISSING]:
            file.write_text(json.dumps(altered(data, path, value)))
            try:
                found = dt.read_map(file)
            except ArgumentError as error:
                refused.append(str(error))
                continue
            used(found)
            accepted.append((path, repr(value)))
    for said in refused:
        assert said.startswith(f"{file}: expected the map.json of `drill-twin map`, found "), said
        assert "\n" not in said
        assert re.search(NAMED.get(field, field), said), said
    assert bool(refused) == (field not in NOT_READ)
    if field not in NOT_READ:
        assert ((field,), "None") not in accepted
        assert field in OF_PEOPLE or ((field,), "'x'") not in accepted


def test_these_are_all_fields(data):
    assert data.keys() == set(FIELDS)


@pytest.mark.parametrize("value", ODD, ids=lambda value: repr(value)[:20])
def test_a_json_that_is_no_map_is_refused(tmp_path, value):
    file = tmp_path / "map.json"
    file.write_text(json.dumps(value))
    with pytest.raises(ArgumentError, match=r"map\.json: expected the map.json of `drill-twin map`, found "):
        dt.read_map(file)


def test_a_key_that_no_map_has_is_left_out(data, tmp_path):
    file = tmp_path / "map.json"
    file.write_text(json.dumps({**data, "of tomorrow": [1]}))
    assert json.loads(json_text(dt.read_map(file).to_dict())) == data
