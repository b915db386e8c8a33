# SPDX-License-Identifier: Apache-2.0
"""`drill-twin export`: CSV and LAS hold the samples of `/rig/state`, converted to the units of their headers."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from drill_twin.cli.analyze import export
from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.report.recording import read_recording


def test_both_files_hold_the_recorded_channels_in_their_units(bench_run, tmp_path, capsys):
    lasio = pytest.importorskip("lasio")
    export(bench_run.bag, las=True, csv=True, out=tmp_path, begin=1.0, end=2.0)
    printed = capsys.readouterr()
    assert [Path(line).name for line in printed.out.split()] == ["rig.csv", "rig.las"]
    assert "N to kN, N m to kN.m, rad/s to rpm" in printed.err
    rig = read_recording(bench_run.bag).rig
    inside = (rig.time >= 1.0) & (rig.time <= 2.0)
    expected = {
        ("TIME", "s"): rig.time, ("WOB", "kN"): rig.bit_force / 1e3, ("HKLD", "kN"): rig.hookload / 1e3,
        ("RPM", "rpm"): rig.top_drive_speed * 30.0 / math.pi, ("TQA", "kN.m"): rig.top_drive_torque / 1e3,
        ("BRPM", "rpm"): rig.bit_speed * 30.0 / math.pi, ("BTQ", "kN.m"): rig.bit_torque / 1e3,
        ("BPOS", "m"): rig.block_position,
    }  # fmt: skip
    las = lasio.read(str(tmp_path / "rig.las"))
    assert las.version["VERS"].value == 2.0
    assert las.well["WELL"].value == "pa6_bench"
    assert [(curve.mnemonic, curve.unit) for curve in las.curves] == list(expected)
    rows = list(csv.reader((tmp_path / "rig.csv").read_text("utf-8").splitlines()))
    assert [name.rpartition(" [")[2] for name in rows[0]] == [f"{unit}]" for _, unit in expected]
    table = np.array(rows[1:], dtype=float).T
    for curve, column, values in zip(las.curves, table, expected.values(), strict=True):
        np.testing.assert_allclose(curve.data, values[inside], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(column, values[inside], rtol=1e-9, atol=1e-12)


def test_what_cannot_be_exported_is_refused(bench_run, tmp_path):
    with pytest.raises(ArgumentError, match="expected --csv, --las, --drillbotics, --rerun or several"):
        export(bench_run.bag)
    with pytest.raises(BagError, match="expected a start before the end, found 2 s and 1 s"):
        export(bench_run.bag, csv=True, out=tmp_path, begin=2.0, end=1.0)
    (tmp_path / "rig.csv").touch()
    with pytest.raises(BagError, match="expected a new file"):
        export(bench_run.bag, csv=True, out=tmp_path)
