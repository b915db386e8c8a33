# SPDX-License-Identifier: Apache-2.0
"""The estimator node beside a real simulator with hidden numbers, and with samples that are not sound."""

import math

import numpy as np
import pytest
from sensor_msgs.msg import JointState

from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.dynamics.sensors.sampling import Reading
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.sensor_messages import ImuEncoder
from drill_twin.io.messages.topics import ESTIMATE, ESTIMATE_STATE, MEASURED_RIG_STATE, RIG_STATE

COARSE = (
    "numerics.elements=8; numerics.step=10 ms; numerics.frame_rate=50 Hz; rig.rotation.duration=1 s; "
    "rig.weight_on_bit.duration=1 s"
)
"""Kernel of the paper's rod."""
SUB = "sensors.subs=[{name: near_bit, distance_from_bit: 1 m, radius: 6 mm, rate: 50 Hz}]"
FREE = "bit_friction.coefficient=0.03..0.2; load_factor=0.7..1.3"


def values_of(raw):
    state = read_joint_state(raw)
    return dict(zip(state.names, state.position.tolist(), strict=True))


@pytest.mark.long
def test_hidden_numbers_are_found_beside_a_simulator(bench):
    found = bench.collect(ESTIMATE_STATE)
    estimator = bench.start(
        "estimator", "-r", f"measured/rig/state:={RIG_STATE[1:]}", overrides=f"{COARSE}; {SUB}", free=FREE, members=8,
        set_points="scene", horizon=0.0, subs="near_bit",
    )  # fmt: skip
    bench.until_ready("estimator")
    shown = []
    bench.node.create_subscription(JointState, ESTIMATE + RIG_STATE, shown.append, 1000)
    hidden = f"{COARSE}; {SUB}; effects.bit_friction.coefficient=0.11; rig.weight_on_bit.value=46 N"
    simulator = bench.start("simulator", duration=12.0, overrides=hidden)
    driver = bench.start("rig_driver", wait_for="simulator estimator test", overrides=hidden)
    bench.until(lambda: simulator.code is not None and len(found) >= 10, what="the run and its estimates")
    for process in (estimator, driver):
        assert process.end() == 0, process.text
        assert "Traceback" not in process.text
    last = values_of(found[-1])
    assert math.isclose(last["load_factor"], 46 / 40, rel_tol=0.02)
    assert math.isclose(last["bit_friction.coefficient"], 0.11, rel_tol=0.1)
    assert last["trust"] < Level.ERROR
    assert all(map(math.isfinite, last.values()))
    assert {"mark_2/x", "bit_torque/low", "bit_torque/high", "bit_torque/deviation"} <= last.keys()
    assert {tuple(values_of(raw)) for raw in found} == {tuple(last)}  # the same names in all
    assert float(bench.statuses["estimator"].values["misfit_near_bit/speed"]) < 0.1
    assert len(shown) >= 450
    assert list(shown[-1].name) == list(RIG_JOINTS)


def test_bad_samples_are_told_and_survived(bench):
    found = bench.collect(ESTIMATE_STATE)
    estimator = bench.start(
        "estimator", overrides=f"{COARSE}; {SUB}", free=FREE, members=4, show=False, horizon=0.0,
        subs="measured/near_bit",
    )  # fmt: skip
    publisher, template = bench.publisher(MEASURED_RIG_STATE), JointStateTemplate(RIG_JOINTS)
    imu = bench.publisher("/measured/downhole/near_bit/imu")
    sub = ImuEncoder("near_bit", 0.0, 0.0)
    bench.until_ready("estimator")
    draw = np.random.default_rng(1)
    nan = [math.nan] * 4
    for number in range(300):
        stamp = 20_000_000 * number + (3_600_000_000_000 if number > 150 else 0)  # the clock is set
        torque = 1e30 if number == 77 else math.inf if number == 90 else 0.01 * draw.standard_normal()
        raw = template.fill(stamp, nan, nan, [torque, math.nan, 30.0 + 0.1 * draw.standard_normal(), math.nan])
        for _ in range(2 if number == 30 else 1):
            publisher.publish(bytes(raw))
        force = 1e7 if number == 60 else 0.01 * draw.standard_normal()
        if not 210 <= number < 220:
            imu.publish(sub.encode(Reading((stamp - 10_000_000) / 1e9, np.array([force, 0.0, 9.81, 0.0, 0.0, 0.0]))))
        if number == 40:
            publisher.publish(b"\x00\x01\x00\x00 no message")
        bench.spin(0.002)
    bench.until(lambda: len(found) >= 5, what="estimates")
    values = bench.until_status("estimator", lambda status: "samples_clock_jump" in status.values).values
    assert int(values["samples_absurd"]) >= 1
    assert values["samples_repeated"] == "1"
    assert values["samples_clock_jump"] == "1"
    assert values["samples_impossible_reading"] == "1"
    assert int(values["samples_window_without_readings"]) >= 1
    assert estimator.end() == 0, estimator.text
    assert "Traceback" not in estimator.text


def test_a_number_that_it_cannot_change_ends_it_in_a_line(bench):
    estimator = bench.start("estimator", free="hole.radius=80 mm..95 mm")
    assert estimator.wait() == 2, estimator.text
    assert "shapes the mesh" in estimator.text
    assert "Traceback" not in estimator.text
