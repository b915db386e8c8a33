# SPDX-License-Identifier: Apache-2.0
"""The two-sided spectrum shows an orbit at its signed frequency and its own radius."""

import numpy as np
import pytest

from drill_twin.whirl import AnalysisError, spectrum_over_time, two_sided_spectrum

TIME = np.arange(0.0, 30.0, 0.01)


def orbit(radius, frequency):
    return radius * np.exp(2j * np.pi * frequency * TIME)


@pytest.mark.parametrize("segment", [None, 8.0])
def test_forward_and_backward_lines_apart(segment):
    z = 0.02 + orbit(0.01, 2.0) + orbit(0.05, 1.03) + orbit(0.03, -0.402)
    spectrum = two_sided_spectrum(TIME, z, segment=segment)
    forward, backward = spectrum.peak(0.1, 1.5), spectrum.peak(-np.inf, -0.1)
    assert forward.frequency == pytest.approx(1.03, abs=0.005)
    assert backward.frequency == pytest.approx(-0.402, abs=0.01)
    assert forward.radius == pytest.approx(0.05, rel=0.02)
    assert backward.radius == pytest.approx(0.03, rel=0.05)
    assert spectrum.peak(1.8, 2.2).frequency == pytest.approx(2.0, abs=0.005)
    assert spectrum.peak(-0.02, 0.02).radius < 0.005  # the offset, 0.02, is taken out


def test_the_highest_line_of_a_band():
    spectrum = two_sided_spectrum(TIME, orbit(0.05, 2.0) + orbit(0.01, 0.9))
    assert spectrum.peak(0.1, np.inf).frequency == pytest.approx(2.0, abs=0.005)
    assert spectrum.peak(0.1, 1.5).frequency == pytest.approx(0.9, abs=0.005)


def test_irregular_and_broken_records():
    random = np.random.default_rng(1)
    keep = np.sort(random.choice(TIME.size, 2500, replace=False))
    time, z = TIME[keep], orbit(0.05, -0.7)[keep]
    z[::100] = np.nan
    assert two_sided_spectrum(time, z).peak(-np.inf, -0.1).frequency == pytest.approx(-0.7, abs=0.005)


def test_bad_records_are_refused():
    with pytest.raises(AnalysisError, match="at least 16"):
        two_sided_spectrum(TIME[:10], orbit(0.1, 1.0)[:10])
    with pytest.raises(AnalysisError, match="rise"):
        two_sided_spectrum(TIME[::-1], orbit(0.1, 1.0))


def test_spectrum_over_time_follows_a_change():
    z = np.where(TIME < 15.0, orbit(0.05, 1.0), orbit(0.03, -0.6))
    time, frequency, radius = spectrum_over_time(TIME, z, 3.0)
    assert radius.shape == (frequency.size, time.size)
    assert (time[0], time[-1]) == (TIME[0], TIME[-1])
    for when, line, size in (
        (0.0, 1.0, 0.05),
        (0.7, 1.0, 0.05),
        (6.0, 1.0, 0.05),
        (24.0, -0.6, 0.03),
        (29.99, -0.6, 0.03),
    ):
        column = radius[:, np.argmin(np.abs(time - when))]
        assert frequency[np.argmax(column)] == pytest.approx(line, abs=0.1)
        assert column.max() == pytest.approx(size, rel=0.05)
    with pytest.raises(AnalysisError, match="at least 60 s"):
        spectrum_over_time(TIME, z, 60.0)
