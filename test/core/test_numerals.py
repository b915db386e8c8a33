# SPDX-License-Identifier: Apache-2.0
"""Numbers in texts from outside: what Python alone would read as one, through each door."""

import pytest

from drill_twin.cli.options import meshes
from drill_twin.core.errors import ArgumentError, DrillTwinError, SceneError
from drill_twin.core.files.yaml_reader import plain_yaml
from drill_twin.core.numerals import number, whole_number
from drill_twin.core.units import UnitError, parse
from drill_twin.core.units.dimension import FORCE
from drill_twin.core.units.ranges import parse_range
from drill_twin.runs.monitor import COUNT, RecordedRejections
from drill_twin.scene import load_scene
from drill_twin.studies.over_depth import coefficients

ODD = (
    "2_0", "2_0.5", "\u0663", "\uff15", "\u00b2", "0x10", "1:30", "nan", "inf", "-inf", "infinity", "1e", "", " 5",
    "5 ", "5\n", "--5", "1,5", "5N", "1__0", "_5", "5_", "\u22125", "1e5_0", "0b1", "1.2.3", ".", "e5", "5\x00",
)  # fmt: skip


@pytest.mark.parametrize("text", ODD)
def test_what_is_no_number(text):
    assert number(text) is None
    assert whole_number(text) is None


def test_what_is_one():
    assert [number(text) for text in ("5", "+5", "-5.", ".5", "1e3", "1.5E-3", "007")] == [
        5,
        5,
        -5,
        0.5,
        1e3,
        1.5e-3,
        7,
    ]
    assert number("1e999") == float("inf")
    assert [whole_number(text) for text in ("0", "007", "9" * 18)] == [0, 7, 10**18 - 1]
    for text in ("9" * 19, "9" * 5000, "1.0", "-1", "+1", "1e3"):
        assert whole_number(text) is None


@pytest.mark.parametrize("text", ["010", "+010", "-017", "0x10", "0b11", "1_0", "1_000.5", "1:30", "1:30.5", "-1:30"])
def test_yaml_reads_no_eights_no_sixties_and_no_underscores(text):
    assert plain_yaml(f"a: {text}") == {"a": text}
    with pytest.raises(SceneError, match=f'expected a number of elements.* found "{text}"'.replace("+", r"\+")):
        load_scene("pa6_bench", overrides={"numerics.elements": text})
    assert load_scene("pa6_bench", overrides={"name": text}).name == text


def test_yaml_reads_numbers():
    assert plain_yaml("[0, 10, -5, +5, 0.5, .5, 5., 1.0e+3, 1.0e-3, 0.0]") == [
        0,
        10,
        -5,
        5,
        0.5,
        0.5,
        5.0,
        1e3,
        1e-3,
        0.0,
    ]
    assert plain_yaml("[.inf, -.Inf, yes, ~, 2026-11-27]") == [float("inf"), -float("inf"), True, None, "2026-11-27"]


@pytest.mark.parametrize("text", ["1 " + "1" * 5000 + "/3 N", "1/1" + "0" * 400 + " N", "1 1" + "0" * 400 + "/1 N"])
def test_endless_fractions_are_refused_in_words(text):
    with pytest.raises(UnitError, match="expected a force"):
        parse(text, FORCE)


def test_options():
    assert meshes("8, 12,16", "8,12,16") == [8, 12, 16]
    for text in ("8,\u00b2", "8,1_6", "8,\u0663\u0663", "8,,16", "8,1", "", "8,16,", "8," + "9" * 5000):
        with pytest.raises(ArgumentError, match="--elements: expected numbers"):
            meshes(text, "8,12,16")
    assert coefficients("0.3, 0.2") == [0.2, 0.3]
    for text in ("0.2,nan", "0.2,0_1", "0.2,\u0663", "0.2,", "inf", "0.2,0x1"):
        with pytest.raises(ArgumentError, match="--friction: expected at most"):
            coefficients(text)
    for text in ("1..1e999 N", "-1e999..1 N"):
        with pytest.raises(ArgumentError, match=r"--wob: expected LO\.\.HI"):
            parse_range("--wob", text)


def test_domains(monkeypatch):
    deployment = pytest.importorskip("drill_twin.ros.deployment")
    monkeypatch.setenv("ROS_DOMAIN_ID", "007")
    assert deployment.domain_of_environment() == 7
    for text in ("4_2", "\u0664\u0662", "\u00b2", "0x2a", "-1", "233", "9" * 5000):
        monkeypatch.setenv("ROS_DOMAIN_ID", text)
        with pytest.raises(DrillTwinError, match="expected a whole number from 0 to 232"):
            deployment.domain_of_environment()


def test_diagnostics_of_another_program():
    found = RecordedRejections()
    for text in ("3", "4_0", "\u0665", "", "9" * 5000):
        found.update({COUNT: text})
    assert found.count == 3
