# SPDX-License-Identifier: Apache-2.0
"""Judgement of a rig's signal: each fault has its sentence and no value."""

import math
from types import SimpleNamespace

import pytest

from drill_twin.core.errors import TableError
from drill_twin.scene.records import read_columns
from drill_twin_rig.gateway.rig_reader import QualityCheck, SignalReading, unit_fault
from drill_twin_rig.gateway.signals import RigSignal
from drill_twin_rig.gateway.wits0 import SentenceReader, WitsReader

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
        ((True,), "expected a number, found True"),
        ((None,), "expected a number, found nothing"),
        (("12",), 'expected a number, found "12"'),
        ((501.0,), "expected 0 to 500 kN, found 501 kN"),
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


SPELLED = (
    "-999.25", "-999.2500", "-9.9925e2", "-999", "-999.0", "-9999", "-9999.00", "-9999.25", "-8888", "9999", "+9999.0",
    "99999", "-32768", "", "NaN", "#N/A", "No Data", "1.#QNAN", "-INF", "null", "-17000", "1e300", "text",
)  # fmt: skip
WEIGHTS = [f"{100.0 + 12.0 * math.sin(0.7 * k):.2f}" for k in range(40)]
SERIES = {
    **{f"weight, {null}": ("weight_on_bit", "kN", [*WEIGHTS, null, *WEIGHTS, null, null]) for null in SPELLED},
    "weight, nulls beside a weight of no rig": ("weight_on_bit", "kN", [*WEIGHTS, "-17000", *WEIGHTS, "-999", "98"]),
    "torque that passes 9999": ("surface_torque", "N m", [f"{9979 + k}" for k in range(40)]),
    "torque that passes -999": ("surface_torque", "N m", [f"{-1019 + k}" for k in range(40)]),
    "torque, a number of the trade among noise": (
        "surface_torque", "N m", [*(f"{5e3 + 4e3 * math.sin(2.0 * k):.0f}" for k in range(40)), "-999"]
    ),
    "torque of 9999 at first": ("surface_torque", "N m", ["9999"] * 5 + ["9000.5", "9000.7", "12"]),
}  # fmt: skip
COLUMN = {"weight_on_bit": "WOB", "surface_torque": "TQA"}


def from_opc_ua(text, stamp):
    """A reading as a server of numbers would give it; what is no number is a text there."""
    try:
        return SignalReading(float(text), "", stamp)
    except ValueError:
        return SignalReading(text or None, "", stamp)


def from_wits(text, stamp):
    sentences = SentenceReader()
    items = [sentences.take(line) for line in ("&&", f"0116{text}", "!!")][-1]
    found = {item: (value, stamp) for item, value in items.items()}
    return next(WitsReader._readings(SimpleNamespace(_items=["0116"], _found=found)))._replace(stamp=stamp)


@pytest.mark.parametrize(("quantity", "unit", "texts"), SERIES.values(), ids=SERIES)
def test_a_value_is_kept_from_opc_ua_from_wits_and_from_a_file_alike(tmp_path, quantity, unit, texts):
    path = tmp_path / "record.csv"
    path.write_text(f"Time [s],{COLUMN[quantity]} [{unit}]\n" + "".join(f"{k},{one}\n" for k, one in enumerate(texts)))
    columns = read_columns(path)
    if "text" in texts:
        with pytest.raises(TableError, match='found "text"'):
            columns.channel(quantity)
        in_file = [math.nan if text == "text" else 1e3 * float(text) for text in texts]
    else:
        in_file = columns.channel(quantity).values.tolist()
    for read in (from_opc_ua, from_wits):
        check = QualityCheck(RigSignal(quantity, unit, 1e3 if unit == "kN" else 1.0, "", -math.inf, math.inf, 2.0, 0.0))
        live = [check.check(read(text, NOW + k), NOW + k).value for k, text in enumerate(texts)]
        assert live == pytest.approx(in_file, rel=1e-12, nan_ok=True)
        assert sum(check.left_out.values()) == sum(map(math.isnan, in_file))


def test_what_is_left_out_is_counted_by_its_kind():
    check = QualityCheck(RigSignal("weight_on_bit", "kN", 1e3, "", -5.0, 500.0, 2.0, 0.0))
    given = (10.0, 10.5, -999.25, -999.25, -9999, math.nan, "No Data", -17e3, 501.0, 11.0)
    faults = [check.check(SignalReading(one, "", NOW + k), NOW + k).fault for k, one in enumerate(given)]
    assert faults[2:5] == ["-999.25 stands for no value", "-999.25 stands for no value", "-9999 stands for no value"]
    assert faults[7] == "beyond any weight on bit, found -17000 kN"
    assert {kind: count for kind, count in check.left_out.items() if count} == {
        "-999.25 stands for no value": 2, "-9999 stands for no value": 1, "expected a finite number": 1,
        "expected a number": 1, "beyond any weight on bit": 1, "expected -5 to 500 kN": 1,
    }  # fmt: skip


def test_a_reading_that_comes_again_is_counted_once():
    check = QualityCheck(RigSignal("weight_on_bit", "kN", 1e3, "", -5.0, 500.0, 0.0, 0.0))
    for _ in range(3):
        assert check.check(SignalReading(math.nan, "", NOW), NOW).fault
    assert sum(check.left_out.values()) == 1


def test_a_set_point_that_a_person_types_may_be_a_number_of_the_trade():
    check = QualityCheck(RigSignal("weight_on_bit", "N", 1.0, "", 0.0, 1e5, 0.0, 0.0, is_typed=True))
    for k, value in enumerate([5000.0] * 30 + [9999.0] * 3):
        assert not check.check(SignalReading(value, "", NOW + k), NOW + k).fault
    assert check.check(SignalReading(-999.25, "", NOW + 40), NOW + 40).fault == "-999.25 stands for no value"


def test_a_value_that_stays_at_a_number_of_the_trade_is_kept_however_long():
    check = QualityCheck(RigSignal("surface_torque", "N m", 1.0, "", 0.0, 1e6, 0.0, 0.0))
    near = [9990.0 + 0.03 * k for k in range(300)]
    for k, value in enumerate([*near, *[9999.0] * 1000]):
        assert not check.check(SignalReading(value, "", NOW + k), NOW + k).fault, k
