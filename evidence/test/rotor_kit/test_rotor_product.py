# SPDX-License-Identifier: Apache-2.0
"""drill_twin's response to the unbalance of discs beside the own elements that the predictions rest on."""

import numpy as np
import pytest

from drill_twin_evidence.rotor_kit.fit import loaded
from drill_twin_evidence.rotor_kit.forecast import SPEEDS
from drill_twin_evidence.rotor_kit.product import has_response, sensitivities
from drill_twin_evidence.rotor_kit.rig import Rigs

if not has_response():
    pytest.skip("this drill_twin has no discs yet", allow_module_level=True)


@pytest.fixture(scope="module")
def z(predictions):
    """The posterior mean, and three draws of the posterior."""
    draws = loaded(predictions / "rk4_fit.json")[1]
    return np.concatenate([draws.mean(axis=0)[None], draws[:3]])


def test_both_models_give_one_prediction(z):
    for row in z:
        rig = Rigs.of(row[None, :-2])
        assert rig.possible()[0]
        own = rig.sensitivities(list(SPEEDS))[:, 0]
        found = sensitivities(rig, np.array(SPEEDS))
        assert np.abs(found / own - 1).max() < 1e-3


def test_a_moved_disc_would_be_seen(z):
    # The disc nearer to mid-span by 5 mm changes vectors by more than the models differ.
    moved = z[:1].copy()
    moved[0, 2] += 5.0 / 18.0
    found = sensitivities(Rigs.of(moved[:, :-2]), np.array(SPEEDS))
    own = Rigs.of(z[:1, :-2]).sensitivities(list(SPEEDS))[:, 0]
    assert np.abs(found / own - 1).max() > 0.01
