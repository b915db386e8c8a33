# SPDX-License-Identifier: Apache-2.0
"""Record of a rig without marks: torque swing, stick-slip index, gaps and spikes; a line is broken at a gap."""

import math
from pathlib import Path

import numpy as np
import pytest

from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.report.figures.style import unbridged
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection
from drill_twin.report.summary import summarise
from drill_twin.report.surface import index_by_torque
from drill_twin.report.text import findings, provenance
from drill_twin.scene import load_scene

WELL_B = Path(__file__).parents[3] / "shared/data/well_b"


def record(path, *, bit=False):
    """60 s of a swing of 8 kN m about 20 kN m every 4 s, with a gap and a spike."""
    time = np.arange(0.0, 60.0, 0.1)
    torque = 20.0 + 4.0 * np.sin(math.tau * time / 4.0)
    torque[450] = 90.0
    kept = (time < 20.0) | (time >= 26.0)
    columns = [time, 0.0 * time + 100.0, 0.0 * time + 90.0, torque, *([90.0 + 45.0 * np.sin(time)] if bit else [])]
    header = "time [s],WOB [kN],RPM [rpm],TQA [kN.m]" + (",BRPM [rpm]" if bit else "")
    np.savetxt(path, np.column_stack(columns)[kept], delimiter=",", header=header, comments="")
    return read_recording(path)


def test_a_record_tells_weight_swing_index_gaps_and_spikes(tmp_path):
    found = summarise(record(tmp_path / "rig.csv"))
    surface = found["surface"]
    assert surface["channels"]["torque"] == {"gaps": [[pytest.approx(19.9), pytest.approx(26.0)]], "spikes": [45.0]}
    swing = surface["torque_swing"]
    assert swing["last_nm"] == pytest.approx(8000.0, rel=0.02)
    assert swing["last"] == pytest.approx(0.4, rel=0.02)
    assert swing["period_s"] == pytest.approx(4.0, rel=0.03)
    rows = dict(findings(found))
    assert rows["stick-slip index"].startswith("unknown: no speed of the bit is recorded")
    assert "the longest from 19.90 to 26.00 s" in rows["gaps, torque"]
    assert rows["weight on bit"].startswith("100")
    assert found["loads"]["top_drive_torque_nm"]["max"] == pytest.approx(24_000.0, rel=1e-3)
    assert [name for name, _ in provenance(found)] == ["recorded time"]
    known = dict(findings(summarise(record(tmp_path / "bit.csv", bit=True))))
    assert float(known["stick-slip index"].partition(" ")[0]) == pytest.approx(0.5, abs=0.03)


def test_a_record_in_pounds_is_told_in_pounds(tmp_path):
    file = tmp_path / "rig.csv"
    rows = "".join(f"{k},20,120\n" for k in range(30))
    file.write_text(f"time [s],WOB [klbf],RPM [rpm]\n{rows}")
    assert dict(findings(summarise(read_recording(file))))["weight on bit"].startswith("20 klbf")
    chosen = summarise(read_recording(file, selection=Selection(units="si")))
    assert dict(findings(chosen))["weight on bit"].startswith("88.96 kN")


def test_a_line_is_broken_where_samples_are_missing():
    time, values = unbridged(np.array([0.0, 1.0, 2.0, 6.0, 7.0]), np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
    assert np.array_equal(values, [1.0, 2.0, 3.0, math.nan, 4.0, 5.0], equal_nan=True)
    assert time.size == 6


def test_the_torque_tells_the_index_of_the_bit():
    """A shaft that is locked at the top and swings in its first mode: torque over speed of the bit is GJ / c."""
    scene = load_scene("wells/vertical_3000")
    section = scene.string.sections[-1]
    uniform = scene.model_copy(update={"string": scene.string.model_copy(update={
        "sections": (section.model_copy(update={"length": scene.length}),),
    })})  # fmt: skip
    tube = tubes_of(uniform)[0]
    shear = tube.youngs_modulus / (2.0 * (1.0 + tube.poisson_ratio))
    speed = math.sqrt(shear / tube.density)
    polar = math.pi / 32.0 * (tube.outer_diameter**4 - tube.inner_diameter**4)
    swing, turn = 4000.0, 10.0
    expected = swing / (shear * polar / speed) / (2.0 * turn)
    found = index_by_torque(uniform, swing, 4.0 * scene.length / speed, turn)
    assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.skipif(not WELL_B.is_dir(), reason="the record of well B is not in this checkout")
def test_swing_of_well_b(tmp_path):
    time = np.arange(0.0, 60.0, 0.05)
    files = (WELL_B / f"B1714_{name}_rec.csv" for name in ("top", "torque"))
    columns = [time, *(np.interp(time, *np.loadtxt(file, delimiter=",").T) for file in files)]
    np.savetxt(tmp_path / "b.csv", np.column_stack(columns), delimiter=",",
               header="time [s],RPM [rpm],TQA [kN.m]", comments="")  # fmt: skip
    swing = summarise(read_recording(tmp_path / "b.csv"))["surface"]["torque_swing"]
    assert swing["period_s"] == pytest.approx(3.95, rel=0.03)
