# SPDX-License-Identifier: Apache-2.0
"""`drill-twin export --rerun`: rerun's own reader finds the run in the file, at the stamps of the bag.

The wheel of rerun-sdk has 170 MB, and 0.5 GB on the disk: it is no package of the tests, which skip what needs it.
"""

import math
import sys

import numpy as np
import pytest

from drill_twin.core.companions import entry_of
from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.io.messages.drawing.geometry import default_exaggeration
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection

NEEDED = "rerun-sdk 0.41 or newer is not installed: pip install 'drill_twin[rerun]' (170 MB)"


def export(bag, folder, **more):
    entry_of("drill_twin.exports", "rerun").load()(bag, Selection(**more), folder, replace=False)
    return folder / "run.rrd"


@pytest.fixture(scope="module")
def read():
    """Reads a file with rerun: rows of a component by the name of its entity, at stamps [ns], static ones at none."""
    chunks = pytest.importorskip("rerun.chunk", reason=NEEDED)

    def rows(file, entity, component):
        found = []
        for chunk in chunks.RrdReader(str(file)).stream():
            batch = chunk.to_record_batch()
            names = [name for name in batch.schema.names if name.endswith(f":{component}")]
            if chunk.entity_path != f"/{entity}" or not names:
                continue
            values = batch.column(names[0]).to_pylist()
            stamps = [None] * len(values) if chunk.is_static else batch.column("time").cast("int64").to_pylist()
            found += zip(stamps, values, strict=True)
        return sorted(found, key=lambda row: row[0] or 0)

    return rows


def test_the_file_has_the_run_at_the_stamps_of_the_bag(bench_run, tmp_path, read):
    file = export(bench_run.bag, tmp_path)
    run = read_recording(bench_run.bag)
    for entity, channel, size in (
        ("weight_on_bit/applied", "bit_force", 1.0), ("rotation/top_drive", "top_drive_speed", math.tau),
        ("torque/top_drive", "top_drive_torque", 1.0), ("torque/bit", "bit_torque", -1.0),
    ):  # fmt: skip
        stamps, values = zip(*read(file, f"trends/{entity}", "scalars"), strict=True)
        assert list(stamps) == run.rig.stamp.tolist(), entity
        np.testing.assert_allclose(np.ravel(values), getattr(run.rig, channel) / size, rtol=1e-12, err_msg=entity)
    for number, mark in enumerate(run.places):
        stamps, strips = zip(*read(file, f"orbits/{mark.name}/path", "strips"), strict=True)
        centre = 1e3 * run.centre_lines()[:, number]
        assert list(stamps) == run.marks.stamp[1:].tolist()
        drawn = np.array(strips)[:, 0]  # two points a sample: the one before, and its own
        np.testing.assert_allclose(drawn[:, 1], np.stack((centre.real, centre.imag), -1)[1:], rtol=1e-6, atol=1e-9)
        ((_, (wall,)),) = read(file, f"orbits/{mark.name}/wall", "strips")
        np.testing.assert_allclose(np.linalg.norm(wall, axis=1), 1e3 * mark.clearance, rtol=1e-6)
    ((at, text),) = [row for row in read(file, "events", "text") if row[1][0].startswith("onset")]
    assert at == pytest.approx(1e9 * run.summary.onset_s, abs=1.0)
    assert run.summary.onset.mark in text[0]
    grades = [value[0] for _, value in read(file, "trends/severity/grade", "scalars")]
    assert set(grades) <= {0.0, 1.0, 2.0, 3.0, 4.0}
    assert grades[-1] > 0.0  # it whirls


def test_lateral_distances_are_enlarged_and_lengths_are_not(bench_run, tmp_path, read):
    file = export(bench_run.bag, tmp_path, begin=1.0, end=2.0)
    run = read_recording(bench_run.bag, None, Selection(begin=1.0, end=2.0))
    factor = default_exaggeration(run.scene.length, run.scene.hole.radius)
    assert factor > 1.0
    stamps, strips = zip(*read(file, "well/string", "strips"), strict=True)
    assert list(stamps) == run.poses.stamp.tolist()
    for shape, pose in zip(strips, run.poses.position, strict=True):
        north, east, down = np.concatenate(shape).T  # of a vertical hole: -x, y, -z
        assert down.max() == pytest.approx(-pose[0, 2], rel=1e-6)
        assert (-factor * pose[0, 0], factor * pose[0, 1]) == pytest.approx((north[0], east[0]), rel=1e-5, abs=1e-9)
    rings = np.concatenate([np.array(strip) for _, row in read(file, "well/hole", "strips") for strip in row])
    np.testing.assert_allclose(np.hypot(*rings.T[:2]), factor * run.scene.hole.radius, rtol=1e-5)
    spots = np.array([row for _, row in read(file, "well/marks", "positions")])
    column = run.marks.names.index(run.places[0].name)
    shown = run.marks.position[np.searchsorted(run.marks.stamp, stamps), column]
    np.testing.assert_allclose(spots[:, 0], shown * (-factor, factor, -1.0), rtol=1e-5, atol=1e-9)


def test_an_older_file_stays(bench_run, tmp_path):
    pytest.importorskip("rerun", reason=NEEDED)
    (tmp_path / "run.rrd").touch()
    with pytest.raises(BagError, match="expected a new file"):
        export(bench_run.bag, tmp_path)


def test_without_rerun_the_message_names_what_to_install(bench_run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(
        ArgumentError, match=r"--rerun: expected the package rerun, .*pip install 'drill_twin\[rerun\]'"
    ):
        export(bench_run.bag, tmp_path)
    assert not list(tmp_path.iterdir())
