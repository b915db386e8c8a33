# SPDX-License-Identifier: Apache-2.0
"""Lateral frequencies and buckling loads of the rod against exact solutions.

Each runs scene -> twin; only the reading of frequencies off the motion is done here. The spatial error of a cubic
element is of fourth order, about 2e-6 of the first frequency at 24 elements; time adds (omega dt)^2 / 12.
"""

import numpy as np
import pytest
from modes import free_motion, squared_frequencies
from scenes import EI, LENGTH, LINE_MASS, rod_scene

FORMS = ("spatial", "lateral")
HUMP = {"lateral_kick": {"velocity": 1e-6, "shape": "hump"}}
WAVE = {"lateral_kick": {"velocity": 1e-6, "shape": "half_wave"}}
UNIT = np.sqrt(EI / LINE_MASS) / LENGTH**2 / (2.0 * np.pi)

# Eigenvalues beta L of the beam equation (Blevins 1979, table 8-1).
MODES = {
    "guided": (HUMP, [4.730040745, 7.853204624, 10.995607838]),
    "pinned": (WAVE, [3.926602312, 7.068582746, 10.210176123]),
    "free": (WAVE, [1.875104069, 4.694091133, 7.854757438]),
    "sliding": (WAVE, [2.365020372, 5.497803919, 8.639379829]),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("bit_end", MODES)
def test_first_three_lateral_frequencies(bit_end: str, form: str) -> None:
    """f_n = (beta_n L)^2 / (2 pi L^2) sqrt(EI / m), within 1e-3 at 24 elements and 1 ms (1e-4 for the first)."""
    kick, eigenvalues = MODES[bit_end]
    scene = rod_scene(effects=kick, bit_end=bit_end, elements=24, step=1e-3, form=form)
    motion = free_motion(scene, seconds=4.0, interval=0.01)
    if bit_end == "guided":  # a symmetric kick leaves the second mode asleep
        eigenvalues = [*eigenvalues[::2], 17.278759657]
    found = np.sqrt(squared_frequencies(motion, 0.01, modes=8)[:3]) / (2.0 * np.pi)
    assert found == pytest.approx(np.array(eigenvalues[:3]) ** 2 * UNIT, rel=1e-3)
    assert found[0] == pytest.approx(eigenvalues[0] ** 2 * UNIT, rel=1e-4)


def lowest(load: float, bit_end: str, form: str) -> float:
    """Lowest omega^2 under an axial load [1/s2]."""
    scene = rod_scene(effects=HUMP, bit_end=bit_end, weight_on_bit=load, step=2e-3, form=form)
    return float(squared_frequencies(free_motion(scene, 6.0, 0.04), 0.04, modes=5)[0])


# Effective length factors of Euler's column; clamped-pinned from tan x = x.
EULER = {"guided": 0.5, "pinned": np.pi / 4.493409458, "sliding": 1.0, "free": 2.0}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("bit_end", EULER)
def test_euler_load(bit_end: str, form: str) -> None:
    """omega^2 passes zero at pi^2 EI / (K L)^2, within 1e-4: oscillation below, growth above."""
    exact = np.pi**2 * EI / (EULER[bit_end] * LENGTH) ** 2
    below, above = lowest(0.99 * exact, bit_end, form), lowest(1.01 * exact, bit_end, form)
    assert below > 0.0 > above
    assert 0.99 + 0.02 * below / (below - above) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("form", FORMS)
def test_self_weight_column(form: str) -> None:
    """A column clamped at its foot buckles under its own weight at w L^3 / EI = 7.8373 (Greenhill 1881), within 1e-3.

    The hole points up (inclination 180 deg), so that the string stands on its clamp.
    """
    exact = 7.83734744 * EI / (LINE_MASS * LENGTH**3)

    def squared(gravity: float) -> float:
        effects = HUMP | {"gravity": {"magnitude": gravity}}
        scene = rod_scene(effects=effects, bit_end="free", inclination=np.pi, step=2e-3, form=form)
        return float(squared_frequencies(free_motion(scene, 4.0, 0.04), 0.04, modes=4)[0])

    below, above = squared(0.99 * exact), squared(1.01 * exact)
    assert below > 0.0 > above
    assert 0.99 + 0.02 * below / (below - above) == pytest.approx(1.0, abs=1e-3)


# Own finite-element table of the paper's rod, vertical (docs/validation.md): load counted at the bit [N].
HANGING = {"guided": 18.83, "pinned": 10.50, "sliding": 8.65, "free": 3.63}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("bit_end", "at"), [(end, "bit") for end in HANGING] + [("guided", "top")])
def test_critical_weight_on_bit_of_the_hanging_rod(bit_end: str, at: str, form: str) -> None:
    """With its weight the rod buckles at the tabled load, counted at the bit or (less its 11.54 N) at the top."""
    exact = HANGING[bit_end] if at == "bit" else 7.29

    def squared(load: float) -> float:
        effects = HUMP | {"gravity": {}}
        scene = rod_scene(effects=effects, bit_end=bit_end, weight_on_bit=load, at=at, step=2e-3, form=form)
        return float(squared_frequencies(free_motion(scene, 6.0, 0.04), 0.04, modes=5)[0])

    below, above = squared(0.99 * exact), squared(1.01 * exact)
    assert 0.99 + 0.02 * below / (below - above) == pytest.approx(1.0, abs=2e-3)
