# SPDX-License-Identifier: Apache-2.0
"""Swept angle: that of an orbit, and none of a swinging or displaced string."""

import math

import numpy as np
import pytest

from drill_twin.whirl.onset.swept_angle import SweptAngle

BINS = np.arange(6 * 16)
ROTATION = 2.0 * np.pi * BINS / 16.0


@pytest.mark.parametrize("ratio", [0.5, 0.05, -0.1, -1.0])
def test_orbit(ratio):
    swept = SweptAngle(np.exp(1j * ratio * ROTATION), ROTATION, 8)
    seen = min(abs(ratio), abs(ratio - 1.0)) * (ROTATION[-1] - math.pi)  # from middle to middle of half revolutions
    assert swept.smallest == pytest.approx(seen, rel=0.15)
    assert swept.steady


@pytest.mark.parametrize("pace", [0.07, 0.3, 0.44, 0.9])
@pytest.mark.parametrize("lift", [0.01, 0.1])
def test_swing_through_the_middle(pace, lift):
    """A hair of noise across the plane makes the angle run round; the area it sweeps is small."""
    across = lift * np.random.default_rng(2).normal(size=BINS.size)
    vector = (np.sin(pace * ROTATION + 0.3) + 1j * across) * np.exp(0.4j)
    assert SweptAngle(vector, ROTATION, 8).smallest < math.radians(30.0)


def test_lean_with_noise():
    random = np.random.default_rng(3)
    vector = 1.0 + 0.3 * (random.normal(size=BINS.size) + 1j * random.normal(size=BINS.size))
    swept = SweptAngle(vector, ROTATION, 8)
    assert swept.smallest < math.radians(20.0)


def test_bow_stands_still_in_the_string():
    assert SweptAngle(np.exp(1j * ROTATION), ROTATION, 8).smallest < 1e-9
