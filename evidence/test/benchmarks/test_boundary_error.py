# SPDX-License-Identifier: Apache-2.0
"""Error of a map's boundary against a dense patch, and its journal."""

from dataclasses import replace

import numpy as np
import pytest

import drill_twin as dt
from drill_twin_evidence.benchmarks.map_boundary import error
from drill_twin_studies.maps.runs import Key

COARSE = {
    "numerics.elements": 8, "numerics.step": "10 ms", "numerics.frame_rate": "50 Hz",
    "rig.rotation.duration": 1.0, "rig.weight_on_bit.duration": 1.0,
}  # fmt: skip
VARY = {"wall_friction.coefficient": "0.1..0.3", "bow.amplitude": "0.01..0.2 mm"}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A map of a coarse bench string."""
    asked = {"wob": "1..40 N", "rpm": "30..180", "duration": 3.0, "steps": 8, "seeds": 2, "growth": False, "vary": VARY}
    return dt.operating_map("pa6_bench", COARSE, folder=tmp_path_factory.mktemp("map"), workers=2, **asked)


def test_the_distance_to_a_dense_patch_is_that_of_the_boundaries(found, tmp_path):
    scene = dt.load_scene("pa6_bench", COARSE)
    distances = error(scene, found, 1, 2, tmp_path, 2)
    assert distances.size
    assert distances.max() < 2.0 / found.plane.steps  # of a map with steps of an eighth of the ranges
    lines = (tmp_path / "patch_0" / "runs.jsonl").read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + 5 * 5
    (tmp_path / "patch_0" / "runs.jsonl").write_bytes(b"".join(lines[:-2]))
    assert np.array_equal(error(scene, found, 1, 2, tmp_path, 1), distances)
    first = [Key(0, j) for j in range(found.plane.steps + 1) if Key(0, j) in found.records]
    moved = {Key(key.i + 2, *key[1:]): record for key, record in found.records.items() if key.i + 1 < found.plane.steps}
    moved |= {Key(i, key.j): found.records[key] for key in first for i in range(2)}
    shifted = replace(found, records=moved)
    assert error(scene, shifted, 1, 2, tmp_path / "shifted", 2).max() > distances.max()
