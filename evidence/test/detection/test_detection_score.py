# SPDX-License-Identifier: Apache-2.0
"""The frozen records stay what they are, and their score tells a good detector from a blind one."""

import math

import numpy as np
import pytest

from drill_twin.report.figures.style import save
from drill_twin_evidence.detection.figure import curves_figure
from drill_twin_evidence.detection.frozen import BASE, KINDS, Finding, by_analyzer, digest, frozen_records, score_of
from drill_twin_evidence.detection.frozen.run_ups import jeffcott
from drill_twin_evidence.detection.frozen.simulated import plans
from drill_twin_evidence.detection.frozen.truth import FIXED, FORWARD, Truth
from drill_twin_evidence.detection.measure import Plan, markdown, measure
from drill_twin_evidence.detection.plain import plain

FROZEN = {
    "a": "40a2e9f1c3019b50",
    "b": "c954ba623c46beab",
    "c": "44dd175e3c58af36",
    "d": "8c563884eb42ab36",
    "e": "b34bb690fbdfdcf4",
    "f": "f5357ecad0b8219e",
    "g": "66e83320db134a61",
    "h": "1cf859634292deee",
}


@pytest.mark.parametrize("kind", FROZEN)
def test_records_and_truths_are_frozen(kind):
    assert digest(list(frozen_records(kind, share=8))) == FROZEN[kind]


def test_runs_are_frozen():
    import hashlib

    assert hashlib.sha256("\n".join(plans()).encode()).hexdigest()[:16] == "878b1da4996b10d4"


def test_digest_sees_a_changed_truth():
    record = next(frozen_records("c"))
    before = digest([record])
    record.truth.amplitude[...] *= 1.02
    assert digest([record]) != before


def test_onset_is_where_the_amplitude_passes_the_level_named():
    turns = np.arange(0.0, 40.0, 0.125)
    amplitude = 0.001 * np.exp(0.2 * turns)[:, None]
    names = (FORWARD,) * turns.size
    truth = Truth(0.5 * turns, turns, amplitude, np.zeros_like(amplitude), names, (names,))
    for level in (0.05, 0.08):
        assert truth.began(level) == pytest.approx(0.5 * math.log(level / 0.001) / 0.2, abs=1e-3)
    assert truth.string_states(0.05)[:100] == [FIXED] * 100
    assert truth.string_states(0.05)[-1] == FORWARD
    assert truth.began(10.0) is None


def _told(truth, level=0.05):
    """What a detector says that knows the truth."""
    began = truth.began(level)

    def states(names):
        return lambda _: [name or FIXED for name in names]

    marks = tuple(states(truth.mark_states(level, k)) for k in range(len(truth.marks)))
    return Finding(began, began, False, level, truth.ratio, states(truth.string_states(level)), marks)


def test_who_knows_the_truth_scores_one_and_who_says_nothing_misses_all():
    records = list(frozen_records("acdeh", share=9))
    known = score_of(records, lambda record: _told(record.truth))["all"]
    assert known.met(1e-6) == known.onsets > 10
    assert (known.plain()["string"], known.plain()["marks"]) == (1.0, 1.0)
    assert known.false == known.missed == []

    def blind(record):
        def still(time):
            return [FIXED] * len(time)

        return Finding(None, None, False, 0.05, None, still, (still,) * len(record.marks))

    silent = score_of(records, blind)["all"]
    assert (len(silent.missed), silent.false) == (known.onsets, [])
    assert silent.plain()["string"] < 0.2


def test_run_up_passes_the_resonance_of_a_rotor():
    """Far from the critical speed and slowly, the response is the steady one, e r^2 / (1 - r^2)."""
    time = np.arange(0.0, 60.0, 0.002)
    speed = np.full(time.size, 3.0)
    path = jeffcott(time, 3.0 * time, speed, 5.0, 0.02)
    ratio = 3.0 / 5.0
    exact = ratio**2 / abs(1.0 - ratio**2 + 2j * 0.02 * ratio)
    assert np.abs(path) == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize(("detector", "least"), [(by_analyzer, 4), (plain, 3)])
def test_detectors_find_what_grows_slowly(detector, least):
    score = score_of(frozen_records("c", share=10), detector)["c"]
    assert score.missed == []
    assert score.onsets == 4
    assert score.met(6.0) >= least
    assert score.plain()["string"] > (0.9 if detector is by_analyzer else 0.5)


def test_other_seeds_give_other_records():
    one, other = (digest(list(frozen_records("a", base=base, share=20))) for base in (BASE, 8_100_000))
    assert one != other


@pytest.mark.long
def test_tables_and_figure(tmp_path):
    result = measure(Plan(10, 0.1, 1))
    text = markdown(result)
    for name in KINDS.values():
        assert f"| {name} |" in text
    save(curves_figure(result.curves), tmp_path / "curves.png")
    assert (tmp_path / "curves.png").stat().st_size > 20_000
