# SPDX-License-Identifier: Apache-2.0
"""Judgement of a rig's signal: each fault has its sentence and no value."""

import math

import pytest

from drill_twin_rig.gateway.rig_reader import QualityCheck, SignalReading, unit_fault
from drill_twin_rig.gateway.signals import RigSignal

SIGNAL = RigSignal("weight_on_bit", "kN", 1000.0, "ns=2;s=WOB", 0.0, 500.0, stale_after=2.0, frozen_after=5.0)
NOW = 1.8e9


@pytest.fixture
def judge():
    check = QualityCheck(SIGNAL)
    return lambda value, status="", age=0.0, now=NOW: check.check(SignalReading(value, status, now - age), now)


def test_a_sound_value_is_in_si(judge):
    checked = judge(12)
    assert (checked.value, checked.fault) == (12000.0, "")


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ((math.nan,), "expected a finite number, found nan"),
        ((math.inf,), "expected a finite number, found inf"),
        ((True,), "expected a number, found bool"),
        ((None,), "expected a number, found NoneType"),
        (("12",), "expected a number, found str"),
        ((501.0,), "expected 0 to 500 kN, found 501"),
        ((12.0, "BadSensorFailure"), "status BadSensorFailure"),
        ((12.0, "", 2.1), "stale stamp"),
        ((12.0, "", -3.0), "stamp in the future"),
        ((12.0, "", math.nan), "no source timestamp"),
    ],
)
def test_a_fault_has_its_sentence_and_no_value(judge, given, fault):
    checked = judge(*given)
    assert checked.fault == fault
    assert math.isnan(checked.value)


def test_a_value_that_never_changes_is_frozen_until_it_does(judge):
    assert not judge(12.0).fault
    assert not judge(12.0, now=NOW + 4.9).fault
    assert judge(12.0, now=NOW + 5.1).fault == "frozen for more than 5 s"
    assert not judge(12.1, now=NOW + 5.2).fault


@pytest.mark.parametrize("same", ["kN", ""])
def test_the_unit_of_the_line(same):
    assert not unit_fault(SIGNAL, same)


@pytest.mark.parametrize("other", ["N", "lbf", "kdaN", "parsec", "%$§"])
def test_another_unit_or_an_unknown_one_is_told(other):
    assert unit_fault(SIGNAL, other) == f"wrong unit: expected kN, found {other} on the server"
