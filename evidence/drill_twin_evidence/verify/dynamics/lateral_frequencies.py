# SPDX-License-Identifier: Apache-2.0
"""Lateral frequencies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from drill_twin_evidence.verify.case import FORMS, case
from drill_twin_evidence.verify.dynamics.modes import loaded_frequency
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import EI, KICK, LENGTH, LINE_MASS, WAVE, quiet_scene
from drill_twin_evidence.verify.signals import free_motion, squared_frequencies

UNIT = float(np.sqrt(EI / LINE_MASS)) / LENGTH**2 / math.tau
MODES = {
    "guided": (KICK, (4.730040745, 10.995607838, 17.278759657)),  # a symmetric kick does not excite the second mode
    "pinned": (WAVE, (3.926602312, 7.068582746, 10.210176123)),
    "free": (WAVE, (1.875104069, 4.694091133, 7.854757438)),
    "sliding": (WAVE, (2.365020372, 5.497803919, 8.639379829)),
}
"""Initial velocity, and beta L of the first three modes that it excites; the top is clamped."""


@case(forms=FORMS, bit_end=tuple(MODES))
def frequencies(bit_end: str, form: str) -> Iterator[Row]:
    """Free vibration of the unloaded rod after a tiny kick, for every bit end.

    The error of cubic elements is of fourth order, 2e-6 of the first frequency at 24 elements; the step of 1 ms adds
    (omega dt)^2 / 12, which is 2e-6 of the first and 4e-4 of the highest frequency here.
    """
    yield from frequency_rows(bit_end, form, 1e-4, 24)


def frequency_rows(bit_end: str, form: str, first: float, elements: int, **numerics: Any) -> Iterator[Row]:
    """First three frequencies at a step of 1 ms; the first is held to a tolerance, the others to 1e-3."""
    kick, eigenvalues = MODES[bit_end]
    scene = quiet_scene(kick, bit_end=bit_end, elements=elements, step=1e-3, form=form, **numerics)
    found = np.sqrt(squared_frequencies(free_motion(scene, 4.0, 0.01), 0.01, modes=8)[:3]) / math.tau
    for value, frequency, tolerance in zip(eigenvalues, found, (first, 1e-3, 1e-3), strict=True):
        yield Row(f"frequency at beta L = {value:.4f} [Hz]", "f = (beta L)^2 / (2 pi L^2) sqrt(EI / m)",
                  "Blevins 1979, table 8-1", value**2 * UNIT, float(frequency), tolerance)  # fmt: skip


@case(forms=FORMS)
def hinged_at_both_ends(form: str) -> Iterator[Row]:
    """First frequency of the rod between hinges; mesh and time step as above."""
    scene = quiet_scene(WAVE, bit_end="pinned", elements=24, step=1e-3, form=form)
    scene = scene.model_copy(update={"string": scene.string.model_copy(update={"top_end": "hinged"})})
    found = np.sqrt(squared_frequencies(free_motion(scene, 4.0, 0.01), 0.01, modes=2)[0]) / math.tau
    yield Row("frequency [Hz]", "f = pi / (2 L^2) sqrt(EI / m)", "Blevins 1979, table 8-1", math.pi**2 * UNIT,
              float(found), 1e-4)  # fmt: skip


@case(forms=FORMS, load=(-40.0, 4.0, 8.0))
def frequency_under_load(load: float, form: str) -> Iterator[Row]:
    """First frequency of the rod between clamps under tension and compression.

    There is no closed form for clamped ends; the reference is the root of the characteristic equation of the loaded
    beam, to round-off. Mesh and time step as without load.
    """
    scene = quiet_scene(KICK, weight_on_bit=load, step=1e-3, form=form)
    found = np.sqrt(squared_frequencies(free_motion(scene, 4.0, 0.01), 0.01, modes=8)[0])
    yield Row(
        what="first frequency [Hz]",
        reference="2 a b (1 - cos aL cosh bL) + (b^2 - a^2) sin aL sinh bL = 0, "
        "a^2, b^2 = sqrt(k^4 + m omega^2 / EI) +- k^2, k^2 = F / 2 EI",
        source="Bokaian 1988, clamped-clamped",
        expected=loaded_frequency(load, 1) / math.tau,
        computed=float(found) / math.tau,
        tolerance=1e-4,
    )
