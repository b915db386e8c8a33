# SPDX-License-Identifier: Apache-2.0
"""Measured weight on bit and speed, played by the rig driver over DDS, reach the string as they were measured."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from drill_twin.io.messages.topics import RIG_COMMAND, RIG_STATE

ROOT = Path(__file__).resolve().parents[2]
RECORD = "175_completo_1.mat"
TURN = 2.0 * math.pi


def _play(bench, joints, simulator, driver):
    """Set-points sent and applied of a run in lockstep, by stamp [ns]."""
    sent, applied = bench.collect(RIG_COMMAND), bench.collect(RIG_STATE)
    process = bench.start("simulator", pace="lockstep", **simulator)
    other = bench.start("rig_driver", wait_for="simulator test", **driver)
    bench.until(lambda: process.code is not None or other.code is not None, what="the run to end")
    assert process.code == 0, bench.logs()
    assert other.end() == 0, bench.logs()
    bench.drain()
    commands = {
        state.stamp: (state.effort[state.index("bit_axial")], state.velocity[state.index("top_drive")])
        for state in joints(sent)
    }
    states = {
        state.stamp: (state.effort[state.index("bit_axial")], state.velocity[state.index("top_drive")])
        for state in joints(applied)
    }
    return commands, states, other.text


def test_a_table_with_a_spike_and_a_gap_is_played_mended_and_said_so(bench, joints, tmp_path):
    time = np.arange(0.0, 3.0, 0.01)
    weight, speed = 20.0 + 5.0 * time, 60.0 + 20.0 * time
    weight[50] = 1e6
    rows = [f"{t:.2f},{w},{n}" for t, w, n in zip(time, weight, speed, strict=True) if not 1.0 < t < 1.2]
    table = tmp_path / "table.csv"
    table.write_text("time_s,wob_N,top_rpm\n" + "\n".join(rows) + "\n", "utf-8")
    columns = (
        "rig.table.time={column: time_s, unit: s}; rig.table.weight_on_bit={column: wob_N, unit: N}; "
        "rig.table.rotation={column: top_rpm, unit: rpm}"
    )
    commands, states, said = _play(bench, joints, {"duration": 2.0}, {"table": str(table), "overrides": columns})
    assert len(states) == 200
    for stamp, (weight_on_bit, rotation) in states.items():
        instant = stamp * 1e-9
        assert weight_on_bit == pytest.approx(20.0 + 5.0 * instant, abs=0.2)
        assert rotation == pytest.approx((60.0 + 20.0 * instant) / 60.0 * TURN, abs=0.02)
        assert commands[stamp] == pytest.approx((weight_on_bit, rotation))
    assert "weight_on_bit: 1 spike (1 sample) taken out, 1 gap (19 samples, longest 0.2 s) bridged" in said


def test_the_record_of_a_real_rig_drives_a_twin_of_it(bench, joints, compiled):
    folders = [Path(os.environ["DRILL_TWIN_DATA"])] if "DRILL_TWIN_DATA" in os.environ else []
    folders = [folder / "ufrj_rig" for folder in [*folders, ROOT.parent / "shared" / "data"]]
    found = [folder / RECORD for folder in folders if (folder / RECORD).is_file()]
    if not found:
        pytest.skip(f"{RECORD} is in none of {', '.join(map(str, folders))}; DRILL_TWIN_DATA names the folder it is in")
    scene = {"scene": "ufrj_rig"}
    compiled("ufrj_rig")
    commands, states, said = _play(bench, joints, {**scene, "duration": 1.5}, {**scene, "table": str(found[0])})
    assert len(states) == 300  # at the scene's 200 frames per second
    weights = [weight for weight, _ in states.values()]
    speeds = [speed for _, speed in states.values()]
    assert 100.0 < min(weights) <= max(weights) < 1000.0
    assert 0.0 < np.mean(speeds) < 20.0
    for stamp, applied in states.items():
        assert commands[stamp] == pytest.approx(applied, abs=1e-6)
    assert f"{RECORD}: 59000 rows over 58.999 s" in said
