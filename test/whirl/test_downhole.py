# SPDX-License-Identifier: Apache-2.0
"""Whirl from one sub: known motions, read with errors in the turning frame, are found again."""

import math

import numpy as np
import pytest
from variants import one_of

from drill_twin.dynamics.sensors.motion import instantaneous
from drill_twin.whirl import AnalysisError, MarkInfo
from drill_twin.whirl.downhole import SubAnalyzer, ToolNoise
from drill_twin.whirl.downhole.high_pass import corner_for
from drill_twin.whirl.downhole.motion import SubMotion

RATE, CLEARANCE, RADIUS, TURN = 100.0, 0.08, 0.03, math.tau * 2.0
NOISE = ToolNoise(0.005, 0.001)
MARK = MarkInfo("sub", 10.0, "centre", 0.09, CLEARANCE)


def read(seconds, ratio, begin, *, level=0.5, slope=0.0, lean=0.0, seed=1, noise=NOISE, growth=2.0):
    """Stamps and readings of a sub whose section begins to whirl; `slope` [1/m] is its tilt over its radius."""
    time = (np.arange(round(seconds * RATE)) + 0.5) / RATE
    rate = ratio * TURN
    growth *= TURN / math.tau
    shape = level * CLEARANCE / (1.0 + np.exp(np.minimum(-growth * (time - begin), 500.0)))
    path = np.exp(1j * rate * time)
    first = growth * shape * (1.0 - shape / (level * CLEARANCE))
    second = growth * first * (1.0 - 2.0 * shape / (level * CLEARANCE))
    acceleration = (second + 2j * rate * first - rate**2 * shape) * path
    tilt, swing = slope * shape * path, slope * (first + 1j * rate * shape) * path
    tangent = np.stack([tilt.real, tilt.imag, np.sqrt(1.0 - np.abs(tilt) ** 2)], -1)
    fall = 9.81 * math.sin(lean), 9.81 * math.cos(lean)
    force = np.stack([acceleration.real - fall[0], acceleration.imag, np.full_like(time, fall[1])], -1)
    spin = TURN * time
    across = swing * np.exp(-1j * spin)
    rates = np.stack([-across.imag, across.real, np.full_like(time, TURN)], -1)
    values = instantaneous(np.array(RADIUS), force, tangent, spin, rates, np.zeros_like(rates))
    draw = np.random.default_rng(seed)
    values += np.repeat(noise, 3) * draw.normal(size=values.shape)
    values += np.array([0.05, -0.05, 0.05, 0.002, -0.002, 0.002])
    return np.round(time * 1e9).astype(np.int64), values


def places(stamp, values, noise=NOISE):
    motion = SubMotion(RADIUS, CLEARANCE, noise)
    found = [place for at, row in zip(stamp.tolist(), values, strict=True) for place in motion.push(at, row.tolist())]
    return motion, np.array([place.position for place in found]), np.array([place.spin for place in found])


def analysed(stamp, values, noise=NOISE):
    """Findings of the whirl analysis for the section of the sub."""
    analyzer = SubAnalyzer(MARK, RADIUS, noise)
    for at, row in zip(stamp.tolist(), values, strict=True):
        analyzer.push(at, row)
    return analyzer.checked_summary()


RATIOS = (-1.2, -0.4, 0.3, 0.7, 1.4)
TILTS = ((0.0, 0.0), (0.2, 0.0), (0.0, 0.6))


@pytest.mark.parametrize(("slope", "lean", "ratio"), one_of(3, ((*tilt, ratio) for tilt in TILTS for ratio in RATIOS)))
def test_sense_ratio_radius_and_onset_are_found(slope, lean, ratio):
    begin = 14.0
    found = analysed(*read(30.0, ratio, begin, slope=slope, lean=lean))
    assert found.mean_ratio == pytest.approx(ratio, abs=0.02)
    crossing = begin - math.log(9.0) / (2.0 * TURN / math.tau)  # of 5 % on the way to 50 %
    assert found.onset_s == pytest.approx(crossing, abs=math.tau / TURN)
    assert found.max_radius_m["sub"] == pytest.approx(0.5 * CLEARANCE, rel=0.15)


def test_a_slow_whirl_of_a_tilted_section_is_not_taken_for_a_larger_one():
    stamp, readings = read(40.0, 0.3, 10.0, slope=0.2, noise=ToolNoise(0.0, 0.0))
    _, position, _ = places(stamp, readings, ToolNoise(0.0, 0.0))
    steady = np.abs(position[-1000:])
    assert steady == pytest.approx(0.5 * CLEARANCE, rel=0.03)


@pytest.mark.slow
def test_steady_rotation_with_noise_has_no_onset():
    found = analysed(*read(600.0, 0.5, 1e6, seed=3))
    assert found.onset is None


@pytest.mark.slow
def test_a_noisier_tool_sees_faster_whirls_only():
    corners = [corner_for(CLEARANCE, ToolNoise(0.005 * k, 0.001 * k), 0.01) for k in (1, 4, 16)]
    assert corners[0] < corners[1] < corners[2]
    assert corner_for(CLEARANCE, ToolNoise(0.0, 0.0), 0.01) == 0.0
    stamp, values = read(600.0, 0.5, 1e6, seed=3)
    motion, position, spin = places(stamp, values, ToolNoise(0.02, 0.004))
    assert motion.corner == corners[1]
    z = position * np.exp(-1j * spin)
    rest = (z - z.mean()) * np.exp(1j * spin)
    expected = corner_noise(corners[1])
    assert np.sqrt(0.5 * np.mean(np.abs(rest[1000:]) ** 2)) == pytest.approx(expected, rel=0.25)


def corner_noise(corner):
    """Standard deviation of the position on an axis behind a high pass at a corner, by the formula's two integrals."""
    frequency = np.linspace(0.01, 100.0, 200_001) * corner
    density = 0.01 * (NOISE.force**2 / frequency**4 + (9.81 * NOISE.rate) ** 2 / frequency**6)
    passed = frequency**8 / (frequency**8 + corner**8)
    return math.sqrt(np.sum(density * passed) * (frequency[1] - frequency[0]) / math.pi)


def test_a_whirl_slower_than_the_corner_is_not_found_and_the_corner_is_told():
    found = analysed(*read(30.0, 0.04, 14.0, level=0.1, growth=0.5))
    assert found.onset is None
    assert found.sub.slowest_hz >= 0.06 * TURN / math.tau


@pytest.mark.parametrize("what", ["with gaps", "still", "too few"])
def test_readings_that_cannot_be_used_are_refused(what):
    stamp, values = read(30.0, 0.5, 10.0)
    if what == "still":
        values[:, 5] = 0.0
    elif what == "too few":
        stamp, values = stamp[::20], values[::20]
    else:
        stamp += np.arange(stamp.size) // 100 * 500_000_000
    with pytest.raises(AnalysisError, match="over 4 revolutions of a sub without a gap, of 4 readings or more"):
        analysed(stamp, values)


@pytest.mark.slow
def test_readings_that_are_lost_repeated_or_absurd_are_survived():
    stamp, values = read(30.0, 0.5, 14.0)
    values[500, 2] = math.nan
    values[700, 0] = 1e30
    kept = np.ones(stamp.size, bool)
    kept[[900, 1200]] = False
    order = np.insert(np.flatnonzero(kept), 1300, [1000, 800])
    found = analysed(stamp[order], values[order])
    assert (found.quality.incomplete, found.quality.late) == (2, 2)
    assert found.mean_ratio == pytest.approx(0.5, abs=0.02)
    whole = analysed(*read(30.0, 0.5, 14.0))
    assert found.onset_s == pytest.approx(whole.onset_s, abs=0.1)


def test_after_a_long_gap_the_analysis_begins_again():
    stamp, values = read(40.0, 0.5, 25.0)
    kept = (stamp < 8e9) | (stamp > 12e9)
    found = analysed(stamp[kept], values[kept])
    assert found.mean_ratio == pytest.approx(0.5, abs=0.02)
    assert found.onset_s == pytest.approx(25.0 - math.log(9.0) / 4.0, abs=0.5)


def test_a_whirl_that_is_there_at_the_start_is_found_and_said_to_be():
    found = analysed(*read(20.0, 0.6, -5.0))
    assert found.onset.at_start
    assert "from the start" in found.onset.criterion
    assert found.mean_ratio == pytest.approx(0.6, abs=0.03)
    assert found.max_radius_m["sub"] < 0.75 * CLEARANCE
    assert "contact" not in found.mark_motion["sub"][-1].criterion


@pytest.mark.slow
def test_the_onset_has_an_uncertainty_and_that_of_a_creeping_orbit_is_not_dated():
    quiet = ToolNoise(0.00125, 0.00025)
    known = analysed(*read(30.0, 0.5, 14.0, noise=quiet), noise=quiet).onset
    assert known.dated
    assert known.uncertainty_s < 0.5
    usual = analysed(*read(30.0, 0.5, 14.0)).onset
    assert usual.uncertainty_s > 2.0 * known.uncertainty_s
    assert abs(usual.time_s - (14.0 - math.log(9.0) / 4.0)) < usual.uncertainty_s
    noise = ToolNoise(0.02, 0.004)
    unknown = analysed(*read(50.0, 0.3, 30.0, noise=noise, growth=0.07), noise=noise).onset
    assert not unknown.dated
    assert "not dated" in unknown.criterion


def test_impacts_are_counted_with_their_peaks():
    stamp, values = read(30.0, 0.3, 14.0)
    hits = [1700, 1900, 2300]
    values[hits, 0] += 20.0
    analyzer = SubAnalyzer(MARK, RADIUS, NOISE)
    for at, reading in zip(stamp.tolist(), values, strict=True):
        analyzer.push(at, reading)
    assert analyzer.motion.impacts.times == pytest.approx([(k + 0.5) / RATE for k in hits], abs=1.6 / RATE)
    found = analyzer.summary().sub
    assert found.impacts == 3
    assert found.impact_rate_hz == pytest.approx(0.1, rel=0.01)
    assert found.largest_impact == pytest.approx(20.0, abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_stick_slip_has_its_share_of_time_at_rest_and_the_radius_of_the_sensor(sense):
    time = (np.arange(6000) + 0.5) / RATE
    speed = np.maximum(0.0, 8.0 + 14.0 * np.sin(math.tau * 0.5 * time))
    values = np.stack([-RADIUS * speed**2, 0.0 * time, 0.0 * time + 9.81, 0.0 * time, 0.0 * time, sense * speed], -1)
    values += np.repeat(NOISE, 3) * np.random.default_rng(2).normal(size=values.shape)
    analyzer = SubAnalyzer(MARK, RADIUS, NOISE)
    for at, reading in zip(np.round(time * 1e9).astype(np.int64).tolist(), values, strict=True):
        analyzer.push(at, reading)
    found = analyzer.summary()
    assert found.stick_slip[-1].period_s == pytest.approx(2.0, rel=0.01)
    assert found.sub.share_at_rest == pytest.approx(np.mean(speed < 0.05 * speed.mean()), abs=0.03)
    assert found.sub.radius_m == pytest.approx(RADIUS, rel=0.02)
