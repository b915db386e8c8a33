# SPDX-License-Identifier: Apache-2.0
"""File of signals: the installed one is read, and what is wrong is said with file and line."""

import math

import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin_rig.gateway.dwis import PROPOSED, PROTOTYPES, UNITS
from drill_twin_rig.gateway.signals import SignalsError, read_signals, signals_path


def test_the_installed_file_shows_every_class_with_a_unit_that_has_a_noun():
    signals = read_signals(signals_path("dwis"))
    assert {one.kind for one in signals.show} >= PROTOTYPES.keys() | PROPOSED.keys()
    assert {one.unit for one in signals.show} <= UNITS.keys()
    assert {one.name: one.factor for one in signals.command}["WOBTarget"] == 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ":1: expected the sections show, command, measure, follow, found none"),
        ("shows: {}", ':1: expected one of show, command, measure, follow, found "shows", did you mean "show"?'),
        ("show:\n  A: 3\n", ":2: A: expected {value: ..., unit: ...}, found 3"),
        (
            "show:\n  A: {value: weight_on_bitt}\n",
            'found "weight_on_bitt", did you mean "weight_on_bit"?',
        ),
        ("show:\n  A: {value: weight_on_bit, unit: rpm}\n", ":2: A: expected a unit of force"),
        ("command:\n  A: {value: hookload, unit: N}\n", ":2: expected one of weight_on_bit, "),
        ("command:\n  A: {value: weight_on_bit, unit: N, low: 2, high: 1}\n", ":2: A: expected numbers low < high"),
        ("measure:\n  hookload: {unit: N}\n", ':2: hookload: expected a node such as "ns=2;s=WOB", found nothing'),
        ("measure:\n  hookload: {unit: N, node: i=1, stale_after: -1}\n", ":2: hookload: expected times [s] from 0"),
        ("follow:\n  hookload: {unit: N, node: i=1}\n", ":2: expected one of weight_on_bit, "),
        ("show: [", ":2: column 1: expected valid YAML"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, text, message):
    file = tmp_path / "signals.yaml"
    file.write_text(text, "utf-8")
    with pytest.raises(DrillTwinError, match=r"signals\.yaml") as error:
        read_signals(file)
    assert message in str(error.value)


def test_an_unknown_name_lists_the_installed_ones():
    with pytest.raises(SignalsError, match="one of dwis"):
        signals_path("nothing")


def test_a_tool_downhole_is_mapped_by_name_and_unit(tmp_path):
    file = tmp_path / "rig.yaml"
    file.write_text('measure:\n  near_bit.speed_mean: {node: "ns=2;s=DHRPM", unit: rpm}\n', "utf-8")
    (signal,) = read_signals(file).measure
    assert signal.quantity == "near_bit.speed_mean"
    assert signal.factor == pytest.approx(math.tau / 60.0)
    file.write_text('measure:\n  near_bit.speed: {node: "ns=2;s=DHRPM", unit: rpm}\n', "utf-8")
    with pytest.raises(SignalsError, match=r"near_bit\.speed"):
        read_signals(file)
