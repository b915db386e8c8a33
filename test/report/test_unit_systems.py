# SPDX-License-Identifier: Apache-2.0
"""Who types pounds reads pounds: one system for tables, axes and pages, and SI in the numbers for machines."""

import pytest
from summaries import summarise

from drill_twin.core.units.system import SYSTEMS
from drill_twin.report import draw
from drill_twin.report.charts import view_data
from drill_twin.report.load_text import applied
from drill_twin.report.recording import read_recording
from drill_twin.report.selection import Selection
from drill_twin.report.text import findings
from drill_twin.scene import load_scene


@pytest.mark.parametrize(
    ("quantity", "value", "texts"),
    [
        ("force", 889.6443, ("0.2 klbf", "0.8896 kN", "889.6 N")),
        ("length", 3048.0, ("10000 ft", "3048 m", "3048 m")),
        ("torque", 1355.8, ("1 klbf ft", "1.356 kN m", "1356 N m")),
        ("offset", 0.0254, ("1.000 in", "25.4 mm", "25.4 mm")),
        ("rotation", 12.56637, ("120 rpm", "120 rpm", "2 rev/s")),
        ("acceleration", 19.6133, ("2 g", "2 g", "2 g")),
        ("stress", 6.894757e6, ("1 ksi", "6.895 MPa", "6.895 MPa")),
        ("rate", 0.00846667, ("100 ft/h", "30.48 m/h", "30.48 m/h")),
    ],
)  # fmt: skip
def test_units_of_a_quantity(quantity, value, texts):
    assert tuple(SYSTEMS[name].text(value, quantity) for name in ("field", "si", "lab")) == texts


@pytest.mark.parametrize(
    ("overrides", "system"),
    [
        ({}, "lab"), ({"wob": "6 kN"}, "si"), ({"wob": "2 klbf"}, "field"), ({"units": "si", "wob": "2 klbf"}, "si"),
        ({"units": "field"}, "field"),
    ],
)  # fmt: skip
def test_a_scene_has_the_units_that_it_is_typed_in(overrides, system):
    assert load_scene("pa6_bench", overrides=overrides).unit_system is SYSTEMS[system]


def test_a_report_in_field_units_keeps_the_numbers_in_si(known_bag):
    shown = read_recording(known_bag, None, Selection(units="field"))
    own, field = summarise(known_bag), summarise(shown)
    assert {**own, "units": "field", "notes": []} == {**field, "notes": []}
    rows = dict(findings(field))
    assert "klbf" in applied(field)
    assert "rpm" in rows["rotation"]
    assert " in (" in rows["largest radius, mark_1"]
    labels = [panel.get_ylabel() for panel in draw("set_points", shown).axes]
    assert labels[:2] == ["weight on bit [klbf]", "rotation [rpm]"]
    assert '"x [in]","y [in]","z [ft]"' in view_data(shown)
