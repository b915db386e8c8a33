# SPDX-License-Identifier: Apache-2.0
"""Laboratory rig of UFRJ (doi 10.1016/j.petrol.2018.07.008): torsional stick-slip of a slender shaft."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drill_twin.api import Ensemble, fit, load_scene, read_record
from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin_evidence.validation.comparison import Comparison, Trace, Validation, cycle_length, rms

FILE = "175_completo_1.mat"
COLUMNS = ("time=Time_Sample_175_complete:s", "bit_speed=Bit_Speed_Sample_175_complete:rpm")
FREE = {
    "string.sections.0.youngs_modulus": "60 GPa..600 GPa",
    "internal_damping.torsion_time": "20 ms..200 ms",
    "bit_mass.inertia": "1e-4 kg m^2..3e-3 kg m^2",
    "bit_torque_stribeck.decay": "0.005 s/rad..0.1 s/rad",
    "bit_torque_stribeck.exponent": "1..2",
}
"""Ranges of the fit."""
FIRST, FITTED, LAST = 1.0, 25.0, 58.9
"""Start of the comparison, end of the fit, end of the prediction [s]."""
RATE = 500.0
"""Rate of frames [Hz]: set-points follow frames, and the top swings at up to 40 Hz where the motor stalls."""
AT_REST = 1.0
"""Speed below which the bit is at rest [rad/s]: the noise of its encoder is half of it."""
ABOUT = (
    "Top speed is that of the record, swings of the stalled motor included; weight on bit is its mean over the first "
    "25 s: the friction does not follow its swings. Stiffness, damping, inertia and the fall of friction with speed "
    "were fitted to the bit speed of the first 25 s; from 25 s on it is a prediction. Only ratios of torques are "
    "determined: the friction at rest is set to the largest torque measured in the first 25 s."
)


def validate(folder: Path, *, refit: bool) -> Validation:
    """Bit speed from top speed and mean weight on bit alone.

    Args:
        folder: Folder of the record.
        refit: Fit the numbers again, instead of taking those of the scene.
    """
    overrides = {"rig.table.file": str(folder / FILE)}
    record = read_record(folder / FILE, COLUMNS)
    scene = load_scene("ufrj_torsion", overrides)
    if refit:
        found = fit(record, scene, FREE, begin=FIRST, end=FITTED, rate=RATE, members=48, rounds=24)
        scene = found.scene_of(found.best)
    time, top, bit = _run(scene)
    measured = record.at("bit_speed", time)
    seen, ahead = (time > FIRST) & (time <= FITTED), time > FITTED
    error = "rms error over the mean speed [-]"
    rows = [
        Comparison(error, "fit", None, _error(bit, measured, seen), 0.15),
        Comparison(error, "prediction", None, _error(bit, measured, ahead), 0.15),
        Comparison("naive: the bit turns as the top", "prediction", None, _error(top, measured, ahead), math.inf),
    ]
    pair = (measured[ahead], bit[ahead])
    features = {
        "mean bit speed [rad/s]": [x.mean() for x in pair],
        "length of a cycle [s]": [cycle_length(x, 1.0 / RATE, 0.2, 0.7) for x in pair],
        "peak of the bit speed, 99 % quantile [rad/s]": [np.quantile(x, 0.99) for x in pair],
        "share of the time at rest [-]": [np.mean(np.abs(x) < AT_REST) for x in pair],
    }
    rows += [Comparison(what, "prediction", float(m), float(c), 0.05) for what, (m, c) in features.items()]
    return Validation("ufrj_rig", scene.name, ABOUT, rows, [Trace("bit speed [rad/s]", time, measured, bit)], FITTED)


def _run(scene: Scene) -> tuple[Array, Array, Array]:
    """Time, top speed and bit speed of a run over the whole record."""
    found = Ensemble(scene, {"seed": [scene.numerics.seed]}).run(LAST, outputs="channels", mark_rate=RATE)
    return found["time"], found["top_drive_speed"][0], found["bit_speed"][0]


def _error(computed: Array, measured: Array, part: NDArray[np.bool_]) -> float:
    return rms(computed[part] - measured[part]) / float(measured[part].mean())
