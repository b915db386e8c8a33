# SPDX-License-Identifier: Apache-2.0
"""How far a vector turned: an orbit by what it went, a swing and a lean by nothing."""

import math

import numpy as np
import pytest

from drill_twin.whirl.onset.swept_angle import Turned

BINS = np.arange(6 * 16)
ROTATION = 2.0 * np.pi * BINS / 16.0


@pytest.mark.parametrize("ratio", [0.5, 0.05, -0.1, -1.0])
def test_orbit(ratio):
    turned = Turned(np.exp(1j * ratio * ROTATION), ROTATION, 8)
    seen = min(abs(ratio), abs(ratio - 1.0)) * (ROTATION[-1] - math.pi)  # from middle to middle of half revolutions
    assert turned.least == pytest.approx(seen, rel=0.15)
    assert turned.creeps


@pytest.mark.parametrize("pace", [0.07, 0.3, 0.44, 0.9])
@pytest.mark.parametrize("lift", [0.01, 0.1])
def test_swing_through_the_middle(pace, lift):
    """A hair of noise across the plane makes the angle run round; the area it sweeps is small."""
    across = lift * np.random.default_rng(2).normal(size=BINS.size)
    vector = (np.sin(pace * ROTATION + 0.3) + 1j * across) * np.exp(0.4j)
    assert Turned(vector, ROTATION, 8).least < math.radians(30.0)


def test_lean_with_noise():
    random = np.random.default_rng(3)
    vector = 1.0 + 0.3 * (random.normal(size=BINS.size) + 1j * random.normal(size=BINS.size))
    turned = Turned(vector, ROTATION, 8)
    assert turned.least < math.radians(20.0)


def test_bow_stands_still_in_the_string():
    assert Turned(np.exp(1j * ROTATION), ROTATION, 8).least < 1e-9
