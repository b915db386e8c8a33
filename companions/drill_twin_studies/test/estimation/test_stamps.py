# SPDX-License-Identifier: Apache-2.0
"""Records whose stamps lie off the grid of the estimator, slow ones, and what is not told of these."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy import special
from variants import one_of

import drill_twin as dt
from drill_twin_studies.estimation.estimate import Swing, WindowTiming, bands_of
from drill_twin_studies.fitting import Record
from drill_twin_studies.fitting.sampling import in_ranges
from drill_twin_studies.goodness import Goodness, sentence, table

OVER = {"wob": 55e3, "numerics.step": "20 ms", "numerics.frame_rate": 10.0}
STICKING, TORSION = "bit_torque_stribeck.sticking", "internal_damping.torsion_time"
FREE = {STICKING: "0.55..0.95", TORSION: "50 ms..400 ms", "load_factor": "0.9..1.1"}
FEW = dt.EstimatorOptions(members=16, horizon=0.0)
PERIOD, SECONDS = 0.02, 31.0


@pytest.fixture(scope="module")
def rig():
    """Channels of a hidden twin in stick-slip at frames of 20 ms, and the integrals of what is measured."""
    over = OVER | {"numerics.frame_rate": 1.0 / PERIOD}
    found = dt.Ensemble("two_mass", {STICKING: [0.71], TORSION: [0.15]}, overrides=over).run(
        SECONDS, outputs=("channels",), mark_rate=1.0 / PERIOD
    )
    sums = {name: np.append(0.0, PERIOD * np.cumsum(found[name][0])) for name in ("torque", "hookload")}
    return found["bit_speed"][0], sums


def follow(rig, stamps, **options):
    """Estimates by means between stamps, stamps before time zero left out."""
    edges = PERIOD * np.arange(rig[1]["torque"].size)
    estimator, estimates = dt.Estimator("two_mass", FREE, overrides=OVER, options=replace(FEW, **options)), []
    draw = np.random.default_rng(2)
    estimator.take(0.0)
    for before, stamp in itertools.pairwise(stamps):
        means = {
            name: float(np.diff(np.interp([before, stamp], edges, of))[0]) / (stamp - before)
            for name, of in rig[1].items()
        }
        noisy = {name: mean * (1.0 + 0.005 * draw.standard_normal()) for name, mean in means.items()}
        estimator.take(stamp, noisy)
        while (found := estimator.step()) is not None:
            estimates.append(found)
    assert not {"clock jump", "late", "missing window"} & estimator.intake.troubles.keys()
    return estimates


@pytest.mark.parametrize("offset", one_of(3, [0.001, 0.0, 0.043]))
@pytest.mark.parametrize("spacing", [0.1, 0.2, 0.02])
def test_stamps_off_the_grid_do_not_shift_the_speed_of_the_bit(rig, offset, spacing):
    estimates = follow(rig, np.arange(offset, SECONDS, spacing))
    late = [each for each in estimates if each.time > 12.0]
    true = np.array([rig[0][round(each.time / PERIOD) - 1] for each in late])
    band = [each.sensors["bit_speed"] for each in late]
    assert np.sqrt(np.mean((true - [of.mean for of in band]) ** 2)) < 0.04 * rig[0].std()  # a shift by 0.1 s: 0.13
    held = [of.low - 0.05 <= value <= of.high + 0.05 for of, value in zip(band, true, strict=True)]
    assert np.mean(held) >= 0.8
    assert estimates[-1].alarm == ""


def test_a_slow_record_is_followed_and_what_it_does_not_tell_is_withheld(rig):
    last = follow(rig, np.arange(0.3, SECONDS, 2.0))[-1]
    assert last.numbers["load_factor"].mean == pytest.approx(1.0, rel=0.01)
    assert last.alarm == ""
    assert last.unmeasured == 0.0
    assert last.withheld.keys() == {"bit_speed", "bit_torque"}
    assert "samples in a cycle of" in last.withheld["bit_speed"]
    assert np.isnan(last.sensors["bit_speed"].low)
    assert last.sensors["weight_on_bit"].mean == pytest.approx(55e3, rel=0.02)
    shown = table(last.goodness).markdown()
    assert "not known" in shown
    assert "nan" not in shown


def test_sentence_does_not_give_a_ratio_to_noise_that_is_not_known():
    slow = Goodness(20, 2.0, 0.0, 0.8, 10.0, 9.0, 0.2, 3.0)
    assert "residual over noise not known, 20% of" in sentence({"torque": slow})
    assert "residual 4 times the noise" in sentence({"torque": replace(slow, noise=0.5)})


def swung(period, size, spacing):
    """What is withheld of members that swing with a period [s], by samples at a distance [s]."""
    swing, phase = Swing(WindowTiming(0.02, 50, 10)), np.linspace(0.0, 1.0, 8)[:, None]
    for window in range(20):
        time = window + 0.02 * np.arange(1.0, 51.0)
        swing.take(5.0 * (1.0 + size * np.sin(2.0 * np.pi * (time / period + phase))))
    return swing.withheld(spacing)


def test_speed_of_the_bit_is_withheld_below_four_samples_in_a_cycle():
    assert not swung(4.6, 1.0, 1.0)
    reasons = swung(2.9, 1.0, 1.0)
    assert reasons.keys() == {"bit_speed", "bit_torque"}
    assert "2.9 samples in a cycle of 2.9 s" in reasons["bit_speed"]
    assert not swung(2.9, 1.0, 0.5)
    assert not swung(2.9, 0.1, 1.0)  # it does not swing
    assert not swung(2.9, 1.0, np.nan)  # nothing is known of the samples yet
    assert swung(0.3, 1.0, 0.01)  # the filter compares ten a second


def test_what_a_record_has_before_its_time_zero_is_no_jump_of_the_clock():
    times = np.arange(-4.9, 8.2, 0.1)
    series = {"torque": (times, 6e3 + np.sin(times)), "hookload": (times, -55e3 + np.sin(times))}
    series["weight_on_bit"] = np.array([-5.0, -0.5, 8.0]), np.array([1.0, 53e3, 53e3])
    estimator = dt.Estimator("two_mass", FREE, overrides=OVER, options=FEW)
    estimates = list(estimator.follow(Record("rig", series, ends=frozenset({"torque", "hookload"}))))
    assert not estimator.intake.troubles
    assert [one.time for one in estimates] == pytest.approx(np.arange(1.0, 9.0))
    assert estimates[0].goodness["torque"].samples == 10
    assert estimates[-1].sensors["weight_on_bit"].mean == pytest.approx(53e3, rel=0.1)


def test_band_of_a_number_and_its_deviation_stay_within_its_range_however_much_they_are_widened():
    ranges = {"load_factor": (0.8, 1.2), TORSION: (0.05, 0.4)}
    normal = np.random.default_rng(3).standard_normal((64, 2)) * 0.2
    for factor in (1.0, 10.0, 1e4):
        for key, band in bands_of(normal, ranges, factor).items():
            low, high = ranges[key]
            assert low <= band.low < band.mean < band.high <= high
            assert band.deviation <= 0.5 * (high - low)
    plain = in_ranges(special.ndtr(normal), ranges).std(axis=0, ddof=1)
    deviations = [band.deviation for band in bands_of(normal, ranges, 1.0).values()]
    assert deviations == pytest.approx(plain.tolist(), rel=0.15)


def test_weight_on_bit_is_no_less_known_than_its_range_after_wrong_joints(rig):
    estimator = dt.Estimator("two_mass", FREE, overrides=OVER, options=FEW)
    estimator.take(0.0)
    for k in range(1, 132):
        values = {name: float(np.diff(of[5 * k - 5 : 5 * k + 1 : 5])[0] / 0.1) for name, of in rig[1].items()}
        joints = ("hookload", "torque") if k <= 120 else ("torque", "hookload")
        estimator.take(0.1 * k, dict(zip(joints, values.values(), strict=True)))
        while (found := estimator.step()) is not None:
            last = found
    assert last.goodness["torque"].chi_square > 100.0
    assert last.numbers["load_factor"].deviation <= 0.1
    assert not last.sensors["weight_on_bit"].deviation > 1.5 * 0.1 * 55e3
