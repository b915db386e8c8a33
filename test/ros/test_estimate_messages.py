# SPDX-License-Identifier: Apache-2.0
"""Messages of an estimate: trust, a band that is withheld, and what is remembered of alarms."""

import math

import pytest

from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level

for package in ("drill_twin_dashboard", "drill_twin_studies"):
    pytest.importorskip(package, reason=f"needs the package {package}")

from drill_twin_dashboard.live.shown import shown_estimates  # noqa: E402
from drill_twin_studies.estimation.doubts import Span  # noqa: E402
from drill_twin_studies.estimation.estimate import Band, Estimate  # noqa: E402
from drill_twin_studies.ros.estimator.messages import encode_estimate, trust_in, values_for_diagnostics  # noqa: E402

SPANS = (Span(12.0, 41.0, 29), Span(60.0, 61.0, 1))


def estimate(unexplained, spans):
    low = math.nan if unexplained else 2.0
    return Estimate(
        time=70.0, numbers={"load_factor": Band(1.0, 0.1, 0.9, 1.1)}, untold={},
        sensors={"bit_speed": Band(2.5, low, low, low)}, withheld={}, whirls=0.0, chance=math.nan,
        unexplained=unexplained, jumps={},
        misfit={"torque": 0.1}, goodness={}, absurd=0, unmeasured=0.0, frames=None, spans=spans,
    )  # fmt: skip


@pytest.mark.parametrize(("unexplained", "level"), [({"torque": 60.0}, Level.WARN), ({}, Level.OK)])
def test_a_doubted_estimate_has_no_bands_of_virtual_sensors_and_the_output_remembers(unexplained, level):
    found = estimate(unexplained, SPANS)
    state = read_joint_state(encode_estimate(1, found))
    values = dict(zip(state.names, state.position.tolist(), strict=True))
    assert (values["trust"], values["alarm"], values["unexplained"]) == (level, float(bool(unexplained)), 30.0)
    assert math.isnan(values["bit_speed/low"]) == bool(unexplained)
    assert values["load_factor/high"] == 1.1
    assert trust_in(found)[0] == level
    assert "from 12.0 to 41.0 s (29 windows)" in values_for_diagnostics(found)["remembered"]
    rows = {row["name"].replace(" ", "_"): row for row in shown_estimates(state)["rows"]}
    assert (rows["bit_speed"]["low"] is None) == bool(unexplained)


def test_nothing_is_remembered_where_no_alarm_stood():
    assert "remembered" not in values_for_diagnostics(estimate({}, ()))
