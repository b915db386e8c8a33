# SPDX-License-Identifier: Apache-2.0
"""Foreign rigs: the one whose law is ours agrees with our kernel; the others do what their names say."""

import numpy as np
import pytest

import drill_twin as dt
from drill_twin_evidence.foreign_rigs.other_rigs import KINDS, recorded
from drill_twin_evidence.foreign_rigs.other_score import Row as OtherRow
from drill_twin_evidence.foreign_rigs.other_score import lines as other_lines
from drill_twin_evidence.foreign_rigs.rigs import (
    DECAY,
    INDICATED,
    LOAD,
    OVERRIDES,
    RADIUS,
    RIGS,
    SCENE,
    SECONDS,
    SLIDING,
    STICKING,
    strongest,
    trial,
)
from drill_twin_evidence.foreign_rigs.score import Row, lines


def test_a_rig_of_our_law_moves_as_our_scene_does():
    rig = trial("mild exponential", 3, noise=0.0)
    own = {key: [rig.truth[key]] for key in (STICKING, SLIDING, DECAY)} | {"wob": [rig.truth[LOAD] * INDICATED]}
    found = dt.Ensemble(SCENE, own, overrides=OVERRIDES).run(SECONDS, outputs="channels", mark_rate=10.0)
    for name, (_, values) in rig.record.series.items():
        part = slice(10, None)  # the weight comes with the first sample
        error = np.sqrt(np.mean((found[name][0][part] - values[part]) ** 2))
        assert error < 0.03 * max(values[part].std(), 1e-3 * np.abs(values).max()), name


@pytest.mark.parametrize("name", RIGS)
def test_records_are_what_their_names_say(name):
    rig, of, again = RIGS[name], trial(name, 2), trial(name, 2)
    time, torque = of.record.series["torque"]
    assert torque.tolist() == again.record.series["torque"][1].tolist()
    assert int((np.diff(time) > 1.0).sum()) >= min(rig.gaps, 1)
    assert (time[0] == pytest.approx(0.1)) is not rig.averaged
    clean = trial(name, 2, noise=0.0).record.series["torque"][1]
    assert np.std(torque - clean) == pytest.approx(0.01 * np.abs(clean).max(), rel=0.2)
    weight = of.truth[LOAD] * INDICATED
    assert of.truth[STICKING] == pytest.approx(strongest(of.mechanics) / (RADIUS * weight))
    assert of.truth[SLIDING] < of.truth[STICKING]


def test_the_score_counts_what_is_held_or_told():
    row = Row(
        rig="mild joined",
        seed=1,
        way="fit",
        held={STICKING: False, LOAD: True},
        wide={LOAD: 2.0},
        told="",
        of_number={},
    )
    other = Row(row, rig="mild tanh", told="the model does not explain torque")
    doubted = Row(row, seed=2, of_number={STICKING: "for this law of friction only"})
    shown = "\n".join(lines([row, other, doubted]))
    assert "rigs kept back: bands hold 2 of 4" in shown
    assert "held or told 3 of 4" in shown
    assert "| mild joined, 2 | no | missed, said | held, 2 |" in shown
    assert "rigs by which it was made: bands hold 1 of 2" in shown
    assert "held or told 2 of 2" in shown
    assert "| mild joined, 1 | no | missed | held, 2 |" in shown


@pytest.mark.parametrize("name", KINDS)
def test_records_of_other_kinds_are_repeated_and_move(name):
    of, again = recorded(name, 2, 30.0), recorded(name, 2, 30.0)
    time, torque = of.record.series["torque"]
    assert torque.tolist() == again.record.series["torque"][1].tolist()
    assert int((np.diff(time) > 1.0).sum()) >= min(KINDS[name].gaps, 1)
    assert np.isfinite(torque).all()
    assert len(of.bit) == 30
    assert 0.3 < of.bit[10:].mean() < 12.0
    assert LOAD in of.truth


def test_the_score_of_other_kinds_shows_what_is_withheld():
    row = OtherRow(kind="own", seed=1, held=0.4, withheld=0.5, wrong=0.1, alarm=0.5, first=12.0, last="",
                   remembered="an alarm stood", numbers={LOAD: True, STICKING: False})  # fmt: skip
    assert "| own, 1 | 40% | 50% | 10% | 12 s | told of earlier | 1 of 2 |" in other_lines([row])[0]
