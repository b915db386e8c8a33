# SPDX-License-Identifier: Apache-2.0
"""Texts with units become SI floats; what is not one is refused with a reason."""

import math
import os
import re
import subprocess
import sys

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drill_twin.core.units import UnitError, factor_of, parse, write
from drill_twin.core.units import dimension as dim
from drill_twin.core.units.dimension import DIMENSIONS
from drill_twin.core.units.parse import editor_pattern
from drill_twin.core.units.registry import registry


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("40 N", dim.FORCE, 40.0),
        ("40N", dim.FORCE, 40.0),
        ("160 kN", dim.FORCE, 160e3),
        ("36 klbf", dim.FORCE, 36e3 * 4.4482216152605),
        ("16.5 mm", dim.LENGTH, 0.0165),
        ("12 1/4 in", dim.LENGTH, 0.31115),
        ("3 metres", dim.LENGTH, 3.0),
        ("3 μm", dim.LENGTH, 3e-6),
        ("5 1/2 in", dim.LENGTH, 0.1397),
        ("-3 1/2 in", dim.LENGTH, -0.0889),
        ("1/2 in", dim.LENGTH, 0.0127),
        ("10 ft", dim.LENGTH, 3.048),
        ("1.10 g/cm^3", dim.DENSITY, 1100.0),
        ("8.34 ppg", dim.DENSITY, 8.34 * 0.45359237 / (231 * 0.0254**3)),
        ("2 rev/s", dim.ANGULAR_SPEED, 4.0 * math.pi),
        ("50 rpm", dim.ANGULAR_SPEED, 50.0 * math.pi / 30.0),
        ("30 deg", dim.ANGLE, math.pi / 6.0),
        ("30°", dim.ANGLE, math.pi / 6.0),
        ("2.3 GPa", dim.PRESSURE, 2.3e9),
        ("30e6 psi", dim.PRESSURE, 30e6 * 4.4482216152605 / 0.0254**2),
        ("1e7 N/m^2.5", dim.HERTZ_STIFFNESS, 1e7),
        ("0.2 N·s/m²", dim.LINEAR_DRAG, 0.2),
        ("0.2 N s m^-2", dim.LINEAR_DRAG, 0.2),
        ("0.2 kg/(m s)", dim.LINEAR_DRAG, 0.2),
        ("3 N m s/rad/m", dim.ROTARY_DRAG, 3.0),
        ("3 N s", dim.ROTARY_DRAG, 3.0),
        ("2 N/m", dim.FORCE_PER_LENGTH, 2.0),
        ("20 cP", dim.VISCOSITY, 0.02),
        ("2 min", dim.TIME, 120.0),
        ("2 g", dim.ACCELERATION, 2.0 * 9.80665),
        ("2 g", dim.MASS, 0.002),
        ("30 %", dim.DIMENSIONLESS, 0.3),
        ("-.5e-3 m", dim.LENGTH, -0.0005),
    ],
)
def test_a_text_with_a_unit_becomes_its_si_value(text, dimension, value):
    assert parse(text, dimension) == pytest.approx(value, rel=1e-15)
    assert re.search(editor_pattern(dimension), text), "the editor refuses what the twin accepts"


_LBF = 4.4482216152605
_GALLON = 231 * 0.0254**3


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("1.2 sg", dim.DENSITY, 1200.0),
        ("1.2 SG", dim.DENSITY, 1200.0),
        ("1.2 g/cm3", dim.DENSITY, 1200.0),
        ("1.2 kg/l", dim.DENSITY, 1200.0),
        ("1200 kg/m3", dim.DENSITY, 1200.0),
        ("10 ppg", dim.DENSITY, 4.5359237 / _GALLON),
        ("10 lb/gal", dim.DENSITY, 4.5359237 / _GALLON),
        ("75 lb/ft3", dim.DENSITY, 75 * 0.45359237 / 0.3048**3),
        ("0.52 psi/ft", dim.DENSITY, 0.52 * _LBF / 0.0254**2 / 0.3048 / 9.80665),
        ("11.8 kPa/m", dim.DENSITY, 11.8e3 / 9.80665),
        ("12 tf", dim.FORCE, 12 * 9806.65),
        ("36 klb", dim.FORCE, 36e3 * _LBF),
        ("36 klbf", dim.FORCE, 36e3 * _LBF),
        ("36 kips", dim.FORCE, 36e3 * _LBF),
        ("5 daN", dim.FORCE, 50.0),
        ("30 klbf ft", dim.TORQUE, 30e3 * _LBF * 0.3048),
        ("30 ksi", dim.PRESSURE, 30e3 * _LBF / 0.0254**2),
        ("3 deg/30 m", dim.CURVATURE, math.radians(3.0) / 30.0),
        ("3 deg/30m", dim.CURVATURE, math.radians(3.0) / 30.0),
        ("3 °/30 m", dim.CURVATURE, math.radians(3.0) / 30.0),
        ("3 deg/100 ft", dim.CURVATURE, math.radians(3.0) / 30.48),
        ("9000 ft", dim.LENGTH, 2743.2),
        ("10 bbl", dim.VOLUME, 420 * _GALLON),
    ],
)
def test_units_of_the_oilfield(text, dimension, value):
    assert parse(text, dimension) == pytest.approx(value, rel=1e-14)
    number, unit = text.split(" ", 1)
    assert factor_of(unit, dimension) * float(number) == pytest.approx(value, rel=1e-14)
    assert re.search(editor_pattern(dimension), text), "the editor refuses what the twin accepts"


@pytest.mark.parametrize(
    ("text", "dimension", "words"),
    [
        ("16.5 kg", dim.LENGTH, '"16.5 kg" (mass)'),
        ("16.5", dim.LENGTH, '"16.5" (no unit)'),
        ("2 Hz", dim.ANGULAR_SPEED, '"2 Hz" (frequency)'),
        ("3 deg/30 m", dim.ANGLE, "(curvature)"),
        ("3 deg/17 m", dim.CURVATURE, "is not a unit"),
        ("40 kgf", dim.MASS, "(force)"),
        ("2 m2.5", dim.LENGTH, "is not a unit"),
        ("2 /s", dim.ANGULAR_SPEED, "(frequency)"),
        ("5 N/m", dim.FORCE, "(stiffness)"),
        ("5 m^5", dim.FORCE, "(length^5)"),
        ("40 n", dim.FORCE, 'did you mean "N"?'),
        ("5 mpa", dim.PRESSURE, 'did you mean "MPa"?'),
        ("3 mtrs", dim.LENGTH, "is not a known unit"),
        ("40 Ns", dim.FORCE, '"Ns" is not a known unit'),
        ("40 nan", dim.FORCE, '"nan" is not a known unit'),
        ("40 pi N", dim.FORCE, '"pi" is not a known unit'),
        ("3 xyzzy", dim.LENGTH, '"xyzzy" is not a known unit'),
        ("N", dim.FORCE, "not a number with a unit"),
        ("", dim.FORCE, "not a number with a unit"),
        ("nan N", dim.FORCE, "not a number with a unit"),
        ("inf N", dim.FORCE, "not a number with a unit"),
        ("1,5 N", dim.FORCE, "not a unit"),
        ("1e999 N", dim.FORCE, "finite"),
        ("1 1/0 in", dim.LENGTH, "division by zero"),
        ("٣ N", dim.FORCE, "not a number with a unit"),
        ("2 N^9^9^9^9", dim.FORCE, "not a unit"),
        ("2 N**99999999", dim.FORCE, "not a unit"),
        ("2 m^m", dim.LENGTH, "not a unit"),
        ("2 __import__('os')", dim.LENGTH, "not a unit"),
        ("2 N(", dim.FORCE, "not a unit"),
        ("1 2 N", dim.FORCE, "not a number with a unit"),
        ("2 " + "m " * 1000, dim.LENGTH, "not a unit"),
    ],
)
def test_what_is_no_quantity_of_the_dimension_is_refused(text, dimension, words):
    with pytest.raises(UnitError) as caught:
        parse(text, dimension)
    assert words in str(caught.value)
    assert f"expected {dimension.article}" in str(caught.value) or "finite" in str(caught.value)
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize("dimension", DIMENSIONS, ids=lambda dimension: dimension.name)
def test_every_dimension_reads_its_examples_and_its_si_unit(dimension):
    assert parse(f"1 {dimension.unit}".strip(), dimension) == 1.0
    for text in dimension.examples:
        parse(text, dimension)
        assert re.search(editor_pattern(dimension), text)


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(DIMENSIONS))
def test_a_written_value_reads_back_to_the_same_float(value, dimension):
    assert parse(write(value, dimension), dimension) == value


@settings(deadline=None)
@given(st.text(max_size=40), st.sampled_from(DIMENSIONS))
@example("0:\n0", DIMENSIONS[0])
def test_any_text_is_a_finite_value_or_a_unit_error(text, dimension):
    try:
        assert math.isfinite(parse(text, dimension))
    except UnitError as error:
        assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("word", ["40 kg", "40", "rpm", "40 N s/rad*", "kN 40"])
def test_the_editor_refuses_a_wrong_unit_of_force(word):
    assert not re.search(editor_pattern(dim.FORCE), word) or "*" in word


def test_a_factor_is_checked_for_its_dimension():
    assert factor_of("kN", dim.FORCE) == 1000.0
    assert factor_of("", dim.DIMENSIONLESS) == 1.0
    with pytest.raises(UnitError, match="expected a unit of force"):
        factor_of("kg", dim.FORCE)


def test_the_registry_holds_only_what_scenes_need():
    """A thousand units take 0.2 s to load, at each start of each node."""
    assert len(list(registry())) < 500


@pytest.mark.parametrize(
    ("text", "value"), [('8 1/2"', 0.2159), ('12.25 "', 0.31115), ("8 1/2″", 0.2159), ("100'", 30.48), ("100 ′", 30.48)]
)
def test_inches_and_feet_by_their_signs(text, value):
    assert parse(text, dim.LENGTH) == pytest.approx(value, rel=1e-15)
    with pytest.raises(UnitError, match=r"\(length\)"):
        parse(text, dim.FORCE)


def _factor_in_a_new_process(folder, unit):
    code = (
        "import sys; from drill_twin.core.units.registry import si_factor; "
        f"print(si_factor({unit!r}), 'pint' in sys.modules)"
    )
    environment = {**os.environ, "DRILL_TWIN_CACHE": str(folder)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.rsplit(maxsplit=1)


def test_factors_of_earlier_processes_need_no_pint_and_are_its_factors(tmp_path):
    folder = tmp_path / "cache"
    found, with_pint = _factor_in_a_new_process(folder, "kN m/deg")
    assert with_pint == "True"
    assert _factor_in_a_new_process(folder, "kN m/deg") == [found, "False"]
    (kept,) = folder.glob("units.*.factors")
    kept.write_bytes(kept.read_bytes()[:-1])  # damaged: found anew
    assert _factor_in_a_new_process(folder, "kN m/deg") == [found, "True"]
    folder.chmod(0o500)
    assert _factor_in_a_new_process(folder, "daN/ft")[1] == "True"
    assert _factor_in_a_new_process(tmp_path / "cache" / "no" / "folder", "daN/ft")[1] == "True"
