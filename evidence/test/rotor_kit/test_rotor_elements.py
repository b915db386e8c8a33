# SPDX-License-Identifier: Apache-2.0
"""The finite elements of the rotor kit against closed forms."""

import numpy as np
import pytest

from drill_twin_evidence.rotor_kit.elements import Bearings, Discs, Rotors, mesh
from drill_twin_evidence.rotor_kit.rig import NAMES, Rigs

LENGTH, DIAMETER, YOUNG, DENSITY = 0.48, 0.01, 205e9, 7850.0
BENDING = YOUNG * np.pi * DIAMETER**4 / 64
LINE = DENSITY * np.pi * DIAMETER**2 / 4


def a_rotor(mass=1.6, *, polar=0.0, diametral=0.0, place=0.5, line=1e-9, stiff=1e12, damping=0.0, parts=2):
    """One disc on a shaft in two pinned supports."""
    one = np.array([[1.0]])
    ends = np.array([[0.0, LENGTH]])
    discs = Discs(one * place * LENGTH, one * mass, one * diametral, one * polar, one * damping)
    supports = Bearings(ends, np.full((1, 2, 1, 1), stiff) * np.eye(2), np.zeros((1, 2, 2, 2)), np.zeros((1, 2)))
    nodes = mesh(np.array([[0.0, place * LENGTH, LENGTH]]), parts)
    return Rotors(nodes, np.array([BENDING]), np.array([line]), DIAMETER, discs, supports)


def test_jeffcott_critical_and_response():
    rotor, mass = a_rotor(damping=8.0), 1.6
    stiffness = 48 * BENDING / LENGTH**3
    natural = np.sqrt(stiffness / mass)
    for ratio in (0.5, 1.0, 1.7):
        speed = ratio * natural
        # Friswell et al. 2010, equation 6.12: m w^2 over k - m w^2 + i w c
        exact = speed**2 / (stiffness - mass * speed**2 + 1j * speed * 8.0)
        motion = rotor.unbalance_response(speed, np.array([[LENGTH / 2]]))[0, 0, :, 0]
        assert motion[0] == pytest.approx(exact, rel=2e-4)
        assert motion[1] == pytest.approx(-1j * exact, rel=2e-4)  # turns from x to y


def test_frequencies_of_a_bare_pinned_shaft():
    rotor = a_rotor(1e-9, line=LINE, parts=8)
    found = rotor.frequencies(0.0)[0].imag[::2][:3]
    rotary = (np.pi / LENGTH) ** 2 * DIAMETER**2 / 16
    for mode, value in enumerate(found, start=1):
        exact = (mode * np.pi / LENGTH) ** 2 * np.sqrt(BENDING / LINE / (1 + mode**2 * rotary))
        assert value == pytest.approx(exact, rel=2e-4)


def test_a_disc_that_tilts_splits_into_forward_and_backward_by_the_closed_form():
    # A disc without mass at mid-span tilts alone: Id w^2 - Ip W w - k = 0 with k = 12 E I / L, both signs of w.
    diametral, polar, speed = 4e-4, 7e-4, 300.0
    rotor = a_rotor(1e-9, polar=polar, diametral=diametral)
    stiffness = 12 * BENDING / LENGTH
    forward = (polar * speed + np.sqrt((polar * speed) ** 2 + 4 * diametral * stiffness)) / (2 * diametral)
    backward = forward - polar * speed / diametral
    found = rotor.frequencies(speed)[0].imag
    assert found[0] == pytest.approx(backward, rel=2e-4)
    assert found[1] == pytest.approx(forward, rel=2e-4)


def test_a_support_adds_its_flexibility():
    speed = 1.0  # [rad/s] statics
    motion = a_rotor(stiff=5e4).unbalance_response(speed, np.array([[LENGTH / 2]]))[0, 0, 0, 0]
    assert motion.real == pytest.approx(LENGTH**3 / (48 * BENDING) + 1 / (2 * 5e4), rel=1e-3)


def test_skew_stiffness_drives_forward_whirl():
    one = a_rotor(damping=1.0)
    skew = np.array([[1e5, 8000.0], [-8000.0, 1e5]])
    supports = Bearings(
        one.bearings.places, np.broadcast_to(skew, (1, 2, 2, 2)), np.zeros((1, 2, 2, 2)), np.zeros((1, 2))
    )
    driven = Rotors(one.nodes, one.bending_stiffness, one.mass_per_length, DIAMETER, one.discs, supports)
    assert one.frequencies(0.0)[0, :2].real.max() < 0
    assert driven.frequencies(0.0)[0, :2].real.max() > 0.5


def test_one_element_between_parts_is_enough_for_the_kit():
    z = np.random.default_rng(3).standard_normal((120, len(NAMES)))
    rigs = Rigs.of(z[Rigs.of(z).possible()])
    places = rigs.probe_places()
    few, many = (rigs.seen(rigs.rotors(parts).unbalance_response(105.0, places)) for parts in (1, 6))
    assert np.abs(few / many - 1).max() < 2e-3


def test_a_probe_sees_a_turned_axis_later():
    rigs = Rigs.of(np.zeros((1, len(NAMES))))
    motion = np.array([1.0, -1j])[None, None, :, None] * np.ones((1, 2, 1, 2))  # forward circle
    shown = rigs.seen(motion)[0, :, 0]
    assert np.angle(np.conj(shown[3] / shown[2]), deg=True) == pytest.approx(90.0)
