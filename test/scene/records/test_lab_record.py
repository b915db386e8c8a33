# SPDX-License-Identifier: Apache-2.0
"""The public record of a real rig (thiagoritto/drillstring) is played; no copy of it is kept here."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Schedule

RPM = math.pi / 30.0
NAME = "ufrj_rig/175_completo_1.mat"


@pytest.fixture(scope="module")
def record() -> Path:
    folders = [Path(os.environ["DRILL_TWIN_DATA"])] if "DRILL_TWIN_DATA" in os.environ else []
    folders.append(Path(__file__).resolve().parents[4] / "shared" / "data")
    for folder in folders:
        if (folder / NAME).is_file():
            return folder / NAME
    pytest.skip(f"{NAME} is in none of {', '.join(map(str, folders))}; DRILL_TWIN_DATA names the folder it is in")


@pytest.fixture(scope="module")
def schedule(record: Path) -> Schedule:
    return Schedule.from_scene(load_scene("ufrj_rig", overrides={"rig.table.file": str(record)}))


def test_the_whole_record_is_played(schedule):
    assert schedule.record.duration == pytest.approx(58.999)
    assert len(schedule.record.time) == 59000
    assert schedule.duration == 59.0


def test_the_load_is_played_as_measured(schedule):
    loads = schedule.record.weight_on_bit
    assert (loads.min(), loads.max(), loads.mean()) == pytest.approx((340.0, 743.0, 567.0), abs=1.0)
    assert schedule.record.cleaning["weight_on_bit"].spikes == 0
    assert schedule.at(20.0).weight_on_bit == loads[20000]


def test_the_spikes_of_the_top_speed_are_gone_and_said(schedule):
    """Raw, the channel falls to -263 rpm for a few milliseconds at a time; the rig never turned backwards so."""
    speeds = schedule.record.rotation / RPM
    assert speeds.min() > -10.0
    assert speeds.max() == pytest.approx(152.4, abs=0.1)
    assert np.median(speeds) == pytest.approx(76.0, abs=1.0)
    done = schedule.record.cleaning["rotation"]
    assert 100 < done.spikes < 250
    assert done.spike_samples < 0.05 * 59000
    assert f"rotation: {done.spikes} spikes ({done.spike_samples} samples) taken out" in schedule.record.report
