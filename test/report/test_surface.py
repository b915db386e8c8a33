# SPDX-License-Identifier: Apache-2.0
"""Record of a rig without marks: torque swing, stick-slip index, gaps and spikes; a line is broken at a gap."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from summaries import summarise

from drill_twin.core.errors import TableError
from drill_twin.dynamics.discretisation.discretise import tubes_of
from drill_twin.report import build_report, draw
from drill_twin.report.figures.style import unbridged
from drill_twin.report.load_text import answers
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection
from drill_twin.report.surface import index_by_torque, regular_line
from drill_twin.report.text import findings, provenance
from drill_twin.report.verdict import verdict as on_top
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
    assert swing["largest_nm"] == pytest.approx(8000.0, rel=0.02)
    assert swing["largest"] == pytest.approx(0.4, rel=0.02)
    assert swing["period_s"] == pytest.approx(4.0, rel=0.03)
    rows = dict([*answers(found), *findings(found)])
    assert rows["did it stick"].startswith("no, in the 54 of 60 s with torque at steady rotation, by the torque; ")
    assert rows["how much"].startswith("stick-slip index unknown; the torque swings by 8 kN m at most, 0.4")
    assert "the longest from 19.90 to 26.00 s" in rows["gaps, torque"]
    assert rows["weight on bit"].startswith("100")
    assert found["loads"]["top_drive_torque_nm"]["max"] == pytest.approx(24_000.0, rel=1e-3)
    assert [name for name, _ in provenance(found)] == ["recorded time"]
    known = dict(findings(summarise(record(tmp_path / "bit.csv", bit=True))))
    assert float(known["stick-slip index"].partition(" ")[0]) == pytest.approx(0.5, abs=0.03)


def test_a_bit_that_swings_and_never_stands_does_not_stick_in_any_row(tmp_path):
    """A swing that grows to 0.95 of the mean: its index exceeds 1, as 20 s hold no whole number of its periods."""
    time = np.arange(0.0, 200.0, 0.05)
    bit = 120.0 * (1.0 + 0.95 * time / 200.0 * np.sin(math.tau * time / 8.7))
    table = np.column_stack([time, 0.0 * time + 100.0, 0.0 * time + 120.0, 20.0 + 0.0 * time, bit])
    np.savetxt(tmp_path / "grow.csv", table, delimiter=",", comments="",
               header="time [s],WOB [kN],RPM [rpm],TQA [kN.m],BRPM [rpm]")  # fmt: skip
    assert bit.min() > 6.0
    found = summarise(read_recording(tmp_path / "grow.csv"))
    rows = dict([*answers(found), *findings(found)])
    assert found["stick_slip_index"] > 1.0
    assert rows["did it stick"] == "no, but the bit swings, by the speed of the bit"
    assert on_top(found)[0].startswith("No stick-slip was found, but the bit swings, by the speed of the bit. ")
    assert rows["when"] == "never"
    assert rows["bit at the end"] == "torsional vibration"
    assert rows["stick-slip index"].endswith("at most: medium (an upper estimate: the bit never stuck)")
    assert rows["severity"].startswith("medium of what is known: stick-slip index 1.0")
    assert rows["severity"].endswith("; lateral acceleration unknown (positions of marks are needed)")


def test_a_record_in_pounds_is_told_in_pounds(tmp_path):
    file = tmp_path / "rig.csv"
    rows = "".join(f"{k},20,120\n" for k in range(30))
    file.write_text(f"time [s],WOB [klbf],RPM [rpm]\n{rows}")
    assert dict(findings(summarise(read_recording(file))))["weight on bit"].startswith("20 klbf")
    chosen = summarise(read_recording(file, selection=Selection(units="si")))
    assert dict(findings(chosen))["weight on bit"].startswith("88.96 kN")


KLBF = 4448.2216


def rig_record(path, *, swing=12.0, mean=15.0, steps=0.1, slips=True, bit=False):
    """A connection in slips from 1000 s on, then 100 rpm; from 1100 s the torque swings every 5 s; one spike each."""
    time = np.arange(0.0, 200.0, steps)
    turns = time >= 40.0
    torque = np.where(turns, mean + np.where(time >= 100.0, 0.5 * swing * np.sin(math.tau * time / 5.0), 0.0), 0.0)
    weight = np.where(turns, 20.0, 0.0)
    hookload = 32.0 + np.where(turns | (not slips), 250.0 - weight, 0.0)
    if steps < 1.0:
        torque[1500], hookload[1600] = 99.0, 2000.0
    columns = {
        "time [s]": 1000.0 + time, "WOB [klbf]": weight, "RPM [rpm]": 100.0 * turns, "TQA [kN.m]": torque,
        "HKLD [klbf]": hookload,
    }  # fmt: skip
    if bit:
        columns["BRPM [rpm]"] = turns * np.where(time >= 100.0, np.maximum(100.0 + 150.0 * np.sin(time), 0.0), 100.0)
    np.savetxt(path, np.column_stack([*columns.values()]), delimiter=",", header=",".join(columns), comments="")
    return path


def told(path, **given):
    found = summarise(read_recording(path, **given))
    return found, dict(answers(found))


def test_five_rows_tell_what_a_record_is_good_for(tmp_path):
    found, rows = told(rig_record(tmp_path / "rig.csv"))
    assert list(rows) == ["did it stick", "did it whirl", "how much", "when", "at which weight and speed"]
    assert rows["did it stick"].startswith(
        "likely, by the torque; the speed of the bit, or the string (--scene), tells"
    )
    assert rows["did it whirl"].startswith("not observable: no channel of the surface shows sideways motion")
    assert "swings by 8.833 klbf ft at most every 5.00 s, 0.80 of its mean" in rows["how much"]
    ((start, end),) = found["surface"]["spans"]
    assert start == pytest.approx(1090.0, abs=10.0)
    assert end == pytest.approx(1199.9)
    assert rows["at which weight and speed"].endswith("weight on bit 20 klbf, top drive at 100 rpm.")
    # The string of the scene tells more: so large a swing stops its bit, the same torque about another mean too.
    scene = load_scene("wells/vertical_3000")
    assert told(tmp_path / "rig.csv", scene=scene)[1]["did it stick"] == "likely, by torque and string"


@pytest.mark.parametrize(
    ("kept", "sentence"),
    [
        ({"swing": 1.5}, "no, in the 160 of 200 s with torque at steady rotation, by the torque"),
        # A swing of the whole mean torque that no drill pipe sticks with: 2 x 93 N m s x 100 rpm is 1.9 kN m.
        ({"swing": 1.5, "mean": 1.5}, "no, in the 160 of 200 s with torque at steady rotation, by the torque"),
        ({"steps": 2.0}, "unknown: samples every 2 s show no swing of 2 to 10 s"),
        ({"bit": True}, "yes, by the speed of the bit"),
    ],
)
def test_stick_slip_is_told_as_far_as_the_record_tells(tmp_path, kept, sentence):
    rows = told(rig_record(tmp_path / "rig.csv", **kept))[1]
    assert rows["did it stick"].startswith(sentence)
    expected = {"no": "never in the 160 of 200 s with torque at steady rotation", "un": "unknown"}.get(sentence[:2])
    assert rows["when"] == expected if expected else "s, " in rows["when"]


def test_without_torque_or_a_steady_speed_nothing_tells(tmp_path):
    file = tmp_path / "rig.csv"
    file.write_text("time [s],RPM [rpm],TQA [kN.m]\n" + "".join(f"{k},{k},10\n" for k in range(30)))
    assert told(file)[1]["did it stick"] == "unknown: no steady rotation of the top drive for 20 s"
    file.write_text("time [s],RPM [rpm]\n" + "".join(f"{k},100\n" for k in range(30)))
    found, rows = told(file)
    assert rows["did it stick"] == "unknown: no torque is recorded"
    assert on_top(found)[0].startswith("Whether the bit stuck and slipped is unknown: no torque is recorded. ")


def test_the_hookload_in_slips_is_the_block(tmp_path):
    scene = load_scene("wells/vertical_3000")
    found, _ = told(rig_record(tmp_path / "rig.csv"), scene=scene)
    assert found["block"]["weight_n"] == pytest.approx(32.0 * KLBF, rel=1e-6)
    assert found["block"]["at_s"] < 1040.0
    assert "142.3 kN of the hookload (lowest steady one at rest" in dict(findings(found))["block and top drive"]
    # No slips: the block is not known, and no drag is told, unless its weight is given.
    rig_record(tmp_path / "hung.csv", slips=False)
    unknown, _ = told(tmp_path / "hung.csv", scene=scene)
    assert unknown["block"]["weight_n"] is None
    assert unknown["loads"]["drag_n"] is None
    assert "block_weight=32 klbf" in dict(findings(unknown))["block and top drive"]
    given, _ = told(tmp_path / "hung.csv", scene=scene, selection=Selection(choices=("block_weight=32 klbf",)))
    assert given["loads"]["drag_n"]["mean"] == pytest.approx(found["loads"]["drag_n"]["mean"])
    assert found["loads"]["drag_n"]["min"] == pytest.approx(found["loads"]["drag_n"]["mean"])  # none in slips
    with pytest.raises(TableError, match=r'hung\.csv: block_weight: expected a force .* found "32 ft"'):
        told(tmp_path / "hung.csv", selection=Selection(choices=("block_weight=32 ft",)))


def hung(path, hookload, *, load=0.0, speed=0.0, least=36.0):
    """Weight of the block [klbf] that 600 s at 200 klbf tell, with two times of another hookload; NaN: unknown."""
    time = np.arange(0.0, 600.0)
    columns = [time, 20.0 + 0.0 * time, 120.0 + 0.0 * time, 200.0 + 0.2 * np.sin(time)]
    for begin, now in ((100, hookload), (400, least)):
        for column, value in zip(columns[1:], (load, speed, now), strict=True):
            column[begin : begin + 80] = value
    columns[3][300:316] = 450.0  # an overpull
    heading = "time [s],WOB [klbf],RPM [rpm],HKLD [klbf]"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=heading, comments="")
    return (summarise(read_recording(path))["block"]["weight_n"] or math.nan) / KLBF


def test_what_is_no_slips_is_not_the_block(tmp_path):
    file = tmp_path / "rig.csv"
    assert hung(file, 36.0) == pytest.approx(36.0)
    assert hung(file, 90.0, least=90.0) == pytest.approx(90.0)  # slips recur
    assert math.isnan(hung(file, 90.0, least=200.0))  # a shorter string that hangs, once
    assert math.isnan(hung(file, 150.0, least=150.0))  # the string hangs after an overpull
    assert math.isnan(hung(file, 36.0, load=164.0))  # weight is set down
    assert math.isnan(hung(file, 36.0, speed=math.nan))  # a null value of the speed is no rest


def test_a_given_weight_of_the_block_is_within_the_hookload(tmp_path):
    rig_record(tmp_path / "rig.csv")
    for weight in ("-5 klbf", "3000 klbf"):
        with pytest.raises(TableError, match=r"rig\.csv: block_weight: expected 0 to 8.*e\+06 N .hookload"):
            told(tmp_path / "rig.csv", selection=Selection(choices=(f"block_weight={weight}",)))


def test_the_page_shows_what_is_kept_and_no_empty_well(tmp_path, call):
    rig_record(tmp_path / "rig.csv")
    scene = load_scene("wells/vertical_3000")
    recording = read_recording(tmp_path / "rig.csv", scene)
    panels = draw("set_points", recording).axes
    assert panels[0].get_xlim() == pytest.approx((1000.0, 1199.9))
    torque, hookload = (panel.get_ylim()[1] for panel in panels[2:])
    assert torque < 30.0  # the spike has 99 kN m
    assert hookload < 2000.0  # the spike has 8,900 kN
    files = build_report(recording, tmp_path / "report")
    assert files.figures.keys() == {"set_points"}
    page, rows = files.page.read_text("utf-8"), dict(files.answers)
    assert rows["did it stick"] in page
    assert f'<p class="lead">{rows["at which weight and speed"]}</p>' in page
    said = call("report", str(tmp_path / "rig.csv")).out
    assert said.startswith("The bit probably stuck and slipped, by the torque; ")
    assert "Whirl does not show in a record of the surface." in said
    assert "did it stick " in said
    assert said.endswith("report.html\n")


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
    assert told(tmp_path / "b.csv")[1]["did it stick"].startswith("likely")


def signal(kind, seed, rate, seconds=600.0):
    """Torque about 10 kN m at a rate [Hz]; stick-slip of 3 to 8 s over 60 s, a change that is none, or noise."""
    draw, time = np.random.default_rng(seed), np.arange(0.0, seconds, 1.0 / rate)
    turn, at = (time / draw.uniform(3.0, 8.0) + draw.uniform()) % 1.0, draw.uniform(100.0, 400.0)
    slow = np.clip((time - at) / 30.0, 0.0, 1.0)
    shapes = {
        "sine": np.sin(math.tau * turn), "sawtooth": 2.0 * turn - 1.0, "square": np.tanh(4.0 * np.sin(math.tau * turn)),
        "step": 1.2 * np.sign(time - at), "pulse": -1.2 * ((time > at) & (time < at + 8.0)), "ramp": 2.0 * slow - 1.0,
        "driller": np.sin(math.tau * time / 15.0), "pulses": -1.2 * (time % 60.0 < 8.0),
        "white": draw.normal(0.0, 0.4, time.size),
        "red": 0.5 * lfilter([0.5], [1.0, -0.85], draw.normal(size=time.size)),
    }  # fmt: skip
    shape = shapes[kind]
    if kind in STICKS:
        shape = np.where((time > at) & (time < at + 60.0), shape, 0.0)
    return time, 10.0 + 6.0 * shape + draw.normal(0.0, 0.3, time.size)


STICKS = ("sine", "sawtooth", "square")


def verdict(path, time, torque, **more):
    columns = {"time [s]": time, "RPM [rpm]": 0.0 * time + 120.0, "TQA [kN.m]": torque, **more}
    np.savetxt(path, np.column_stack([*columns.values()]), delimiter=",", header=",".join(columns), comments="")
    return told(path)


@pytest.mark.parametrize("rate", [1.0, 10.0])
@pytest.mark.parametrize("kind", [*STICKS, "step", "pulse", "pulses", "ramp", "driller", "white", "red"])
def test_only_a_swing_that_recurs_is_likely_stick_slip(tmp_path, kind, rate):
    for seed in range(8100, 8103):
        found, rows = verdict(tmp_path / "rig.csv", *signal(kind, seed, rate))
        if kind in STICKS:
            assert rows["did it stick"].startswith("likely"), seed
            assert rows["when"].startswith("about ")
        else:
            assert rows["did it stick"].startswith("unknown: the torque swings by "), seed
            assert rows["when"] == "unknown"
            assert found["surface"]["spans"] == []


@pytest.mark.parametrize("rate", [1, 2, 5, 10])
@pytest.mark.parametrize("memory", [0.0, 0.5, 0.85])
def test_noise_is_seldom_regular(rate, memory):
    """At most 1 in 1000 windows of 40 s."""
    draw, time = np.random.default_rng(9000 + rate), np.arange(40 * rate) / rate
    noise = lfilter([1.0], [1.0, -memory], draw.normal(size=(2000, time.size + 100)))[:, 100:]
    assert sum(regular_line(time, one) is not None for one in noise) <= 2


def test_what_is_not_known_has_its_reason(tmp_path):
    time = np.arange(0.0, 100.0)
    swing = 10.0 + 6.0 * np.sin(math.tau * time / 5.0)
    for times, torque, sentence in (
        (time, 0.0 * time, "unknown: the torque is zero"),
        (10.0 * time, swing, "unknown: samples every 10 s show no swing of 2 to 10 s"),
        (0.1 * time, swing, "unknown: the record is shorter than 20 s"),
        (time, 10.0 + 6.0 * np.sin(math.tau * time / 1.05), "unknown: the torque swings by 1.2"),
    ):
        assert verdict(tmp_path / "rig.csv", times, torque)[1]["did it stick"].startswith(sentence)
    bit = {"BRPM [rpm]": 120.0 + 115.0 * np.sin(math.tau * time / 5.0)}
    rows = verdict(tmp_path / "bit.csv", time, swing, **bit)[1]
    assert rows["did it stick"] == "likely, by the torque; the speed of the bit has too few samples"


def test_the_largest_swing_decides_and_only_what_sticks_is_listed(tmp_path):
    time = np.arange(0.0, 400.0, 0.5)
    half = np.where(time < 200.0, 12.0, 3.0)
    columns = [time, 0.0 * time + 100.0, np.where(time < 200.0, 15.0, 4.0) + 0.5 * half * np.sin(math.tau * time / 5.0)]
    np.savetxt(tmp_path / "rig.csv", np.column_stack(columns), delimiter=",", header="time [s],RPM [rpm],TQA [kN.m]",
               comments="")  # fmt: skip
    found, rows = told(tmp_path / "rig.csv", scene=load_scene("wells/vertical_3000"))
    assert rows["did it stick"] == "likely, by torque and string"
    assert found["surface"]["stick_slip_index_by_torque"] > 1.0
    assert found["surface"]["spans"][-1][1] < 230.0
