# SPDX-License-Identifier: Apache-2.0
"""Errors, rates and delays of instruments, summaries, and the messages of a run with sensors."""

import math

import numpy as np
import pytest

from drill_twin.api.result import Result
from drill_twin.core.errors import ArgumentError
from drill_twin.dynamics.sensors.sampling import (
    Instrument,
    ReadingNoise,
    SurfaceSampler,
    SurfaceValues,
    errors_of,
    with_errors,
)
from drill_twin.dynamics.sensors.subs import SUMMARY, summary
from drill_twin.io.bag.virtual_bags import MemoryBag
from drill_twin.io.messages.decode import read_joint_state
from drill_twin.io.messages.sensor_messages import read_imu, read_summary
from drill_twin.io.messages.topic_row import IMU
from drill_twin.io.messages.topics import SURFACE_STATE, TOPICS, imu_topic, sub_of, summary_topic
from drill_twin.io.messages.type_store import deserialize
from drill_twin.runs.session_run import SessionRun
from drill_twin.scene import load_scene, parse_scene
from drill_twin.scene.blocks.sensors import Accelerometer, SpeedChannel, Surface
from drill_twin.scene.set_points import Command
from drill_twin.whirl import AnalysisError

CHANNELS = (Accelerometer(noise=0.1, bias=0.5, range=2.0, resolution=0.25), SpeedChannel())


def test_errors_are_bias_noise_step_and_range() -> None:
    errors = errors_of(CHANNELS, 3, 0)
    assert errors.bias[0] != 0.0
    assert errors.bias[1] == 0.0
    found = with_errors(np.array([[0.4, 9.0], [5.0, -9.0], [-5.0, 1.0]]), np.ones((3, 2)), errors)
    assert found[0, 0] == round((0.4 + errors.bias[0] + 0.1) / 0.25) * 0.25
    assert found[1:, 0].tolist() == [2.0, -2.0]
    assert found[:, 1].tolist() == [9.0, -9.0, 1.0]


def test_noise_is_white_and_depends_on_the_sample_alone() -> None:
    noise = ReadingNoise(2, 5, 1)
    drawn = np.array([noise.at(k) for k in range(4000)])
    np.testing.assert_array_equal(drawn[700], ReadingNoise(2, 5, 1).at(700))
    assert not np.array_equal(drawn[:256], drawn[256:512])
    assert np.abs(drawn.mean(axis=0)).max() < 0.05
    assert np.abs(np.cov(drawn.T) - np.eye(2)).max() < 0.06


def test_a_sample_is_the_mean_over_its_interval_and_comes_after_its_delay() -> None:
    instrument = Instrument([SpeedChannel()], 20.0, 0.1, 1, 0)
    times, readings = [], []
    for frame in range(1, 41):
        for reading in instrument.advance(frame / 100.0, 0.01, np.array([float(frame)])):
            times.append(frame / 100.0)
            readings.append(reading)
    assert readings[0].time == pytest.approx(0.025)
    assert readings[0].values == pytest.approx(3.0)  # of frames 1 to 5
    assert np.diff([reading.time for reading in readings]) == pytest.approx(0.05)
    assert times[0] == pytest.approx(0.13)


def test_summary_of_a_turning_sub_that_vibrates() -> None:
    phase = np.arange(400) * math.tau / 400
    zero = np.zeros_like(phase)
    speed = 12.0 + 3.0 * np.sin(phase)
    found = summary(np.stack([2.0 * np.sin(phase) - 5.0, zero, 9.81 + zero, zero, zero, speed], -1))
    expected = [9.0, 12.0, 15.0, -5.0, math.sqrt(2.0), 2.0, 0.0, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_the_torque_of_a_drive_includes_its_inertia() -> None:
    drive = {"rig.top_drive.model": "speed_controller", "rig.top_drive.damping": "4 N m s/rad",
             "rig.top_drive.proportional_gain": "1 N m s/rad", "rig.top_drive.integral_gain": "0 N m/rad"}  # fmt: skip
    surface = Surface(rate=1.0, drive_inertia=30.0)
    sampler = SurfaceSampler(load_scene("pa6_bench", overrides=drive), surface, 0.0, 1.5)
    (reading,) = sampler.advance(1.0, SurfaceValues(2.0, 100.0, 0.0, 0.0))
    assert reading.values[1] == 123.0


def test_topics_of_subs_are_of_the_contract() -> None:
    assert sub_of(imu_topic("near_bit")) == "near_bit"
    assert TOPICS["/measured/downhole/a/summary"].name == "/measured/downhole/a/summary"
    assert "/downhole/a/b/imu" not in TOPICS
    assert imu_topic("a") not in list(TOPICS)
    with pytest.raises(KeyError):
        TOPICS["/downhole/a/other"]


SUBS = "[{name: low, distance_from_bit: 500 mm, radius: 5 mm, rate: 50 Hz, accelerometer: {noise: 0.01 m/s^2}}]"
SURFACE = "{rate: 10 Hz, drive_inertia: 0.1 kg m^2, delay: 0.3 s}"


@pytest.fixture(scope="module")
def bag() -> MemoryBag:
    overrides = {"sensors.subs": SUBS, "sensors.surface": SURFACE, "rig.duration": "3 s", "wob": "5 N"}
    scene = parse_scene(load_scene("pa6_bench").to_yaml(), name="x", overrides=overrides)
    recorder = MemoryBag()
    run = SessionRun(scene, recorder)
    for frame in range(1, 301):
        run.advance([Command(5.0, min(12.0, 6.0 * frame / 100.0))])
    return recorder


def test_a_run_records_its_sensors(bag: MemoryBag) -> None:
    raws = [raw for _, _, raw in bag.messages([imu_topic("low")])]
    readings = [read_imu(raw) for raw in raws]
    assert len(readings) == 150
    assert readings[0].stamp == 10_000_000
    message = deserialize(raws[0], IMU)
    assert message.linear_acceleration_covariance[0] == pytest.approx(0.01**2)
    assert not message.angular_velocity_covariance.any()
    last = np.array([reading.values for reading in readings[-30:]])
    assert last[:, 5] == pytest.approx(12.0, abs=0.2)
    assert last[:, 0].mean() == pytest.approx(-0.005 * 144.0, rel=0.1)  # bow and mud of the bench are small
    assert last[:, 2].mean() == pytest.approx(9.81, abs=0.05)


def test_a_bag_is_read_as_arrays(bag: MemoryBag) -> None:
    measured = Result(bag).measured
    low = measured.subs["low"]
    assert low.imu.force.shape == low.imu.rate.shape == (150, 3)
    assert low.imu.time[1] - low.imu.time[0] == pytest.approx(0.02)
    assert len(low.summary.speed_mean) == 5
    assert measured.surface.top_drive_speed[-1] == pytest.approx(12.0, abs=0.1)
    assert measured.skipped == len(measured.rig) == 0


def test_whirl_from_a_sub_is_asked_for_by_its_name(bag: MemoryBag) -> None:
    result = Result(bag)
    with pytest.raises(AnalysisError, match="over 4 revolutions of a sub"):
        result.whirl_from_sub("low")
    with pytest.raises(ArgumentError, match="one of low, found 'high'"):
        result.whirl_from_sub("high")


def test_summaries_are_of_half_a_second(bag: MemoryBag) -> None:
    found = [read_joint_state(raw) for _, _, raw in bag.messages([summary_topic("low")])]
    assert [state.stamp for state in found] == [round(k * 5e8) for k in range(1, 6)]
    values = dict(zip(SUMMARY, read_summary(found[-1]), strict=True))
    assert values["speed_least"] <= values["speed_mean"] <= values["speed_largest"]


def test_surface_channels_have_rate_delay_and_the_inertia_of_the_drive(bag: MemoryBag) -> None:
    found = [(stamp, read_joint_state(raw)) for _, stamp, raw in bag.messages([SURFACE_STATE])]
    assert np.diff([state.stamp for _, state in found]).tolist() == [100_000_000] * (len(found) - 1)
    assert found[0][0] - found[0][1].stamp == pytest.approx(0.3e9, abs=0.011e9)
    early = found[5][1]  # the drive accelerates by 6 rad/s^2
    assert early.effort[0] == pytest.approx(0.6, abs=0.1)
    assert early.names == ("top_drive", "block")
    states = [state for _, state in found]
    assert all(np.isfinite([state.position, state.velocity, state.effort]).all() for state in states)
    speeds = np.array([state.velocity[0] for state in states])
    assert states[-1].position[0] == pytest.approx(0.1 * speeds[1:].sum())  # derived from what is measured
