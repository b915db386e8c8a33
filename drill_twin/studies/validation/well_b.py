# SPDX-License-Identifier: Apache-2.0
"""Well B with the bit at 1,714 m (Aarsnes and Shor 2018, Fig. 15): a start-up off bottom in a deviated well."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from drill_twin.api import Ensemble, Posterior, Record, fit, load_scene
from drill_twin.base.arrays import Array
from drill_twin.scene import Scene
from drill_twin.studies.validation.comparison import Comparison, Trace, Validation, cycle_length, rms

RPM = np.pi / 30.0
ASSEMBLY = 259.08
"""Length of the bottom-hole assembly [m]."""
LAST = 45.0
"""End of the comparison [s]."""
RATE = 25.0
STEADY = 20.0
"""Start of the steady stick-slip [s]."""
FREE = {
    "wall_friction.coefficient": "0.25..0.5",
    "wall_friction.sliding": "0.1..0.25",
    "wall_friction.decay": "10 s/m..36 s/m",
    "wall_friction.exponent": "1..8",
}
"""Ranges of the fit."""
SMOOTHING = 0.5
"""Width of the mean that makes a set-point of the recorded speed of the top drive [s]."""
ABOUT = (
    "Set-point of the top drive from its recorded speed, with its published inertia and controller. Friction along the "
    "string was fitted to the motor torque of 0 to 45 s: all of it is a fit. Of the measured downhole "
    "speed the largest of each half second after 20 s is drawn."
)


def validate(folder: Path, *, refit: bool) -> Validation:
    """Motor torque and downhole speed over the first 45 s.

    Args:
        folder: Folder of the record.
        refit: Fit the numbers again, instead of taking those of the scene.
    """
    with TemporaryDirectory() as place:
        scene = load_scene("well_b", set_point(folder, Path(place)))
        if refit:
            found = fitted(folder, scene)
            scene = found.scene_of(found.best)
        runs = Ensemble(scene, {"seed": [scene.numerics.seed]}).run(LAST, outputs="channels", mark_rate=RATE)
    time, torque, bit = runs["time"], runs["motor_torque"][0], runs["bit_speed"][0]
    measured = torque_record(folder).at("motor_torque", time)
    steady, start = time > STEADY, time < STEADY
    edges, low, high = _downhole(folder)
    ends = [np.searchsorted(time, (edge - 0.5, edge), "right") for edge in edges]
    computed = np.array([(bit[i:j].min(), bit[i:j].max()) for i, j in ends])
    pair = (measured[steady], torque[steady])
    whole, record = (float(x) for x in (np.ptp(computed), high.max() - low.min()))
    deviation = rms(torque - measured) / float(measured.std())
    period = [cycle_length(x, 1.0 / RATE, 2.5, 6.0) for x in pair]
    rows = [
        Comparison("rms error of the torque over its deviation", "fit", None, deviation, 0.5),
        Comparison("break-off torque [N m]", "fit", float(measured[start].max()), float(torque[start].max()), 0.1),
        Comparison("period of the torque after 20 s [s]", "fit", period[0], period[1], 0.05),
        Comparison("range of the downhole speed after 20 s [rad/s]", "fit", record, whole, 0.15),
    ]
    middle = np.where(steady, np.interp(time, edges - 0.25, high), np.nan)
    traces = [Trace("motor torque [N m]", time, measured, torque), Trace("downhole speed [rad/s]", time, middle, bit)]
    return Validation("well_b", scene.name, ABOUT, rows, traces, LAST)


def fitted(folder: Path, scene: Scene) -> Posterior:
    """Fit of the friction along the string to the motor torque."""
    return fit(torque_record(folder), scene, FREE, end=LAST, rate=5.0, members=16, rounds=6, effective=16)


def torque_record(folder: Path) -> Record:
    """Recorded torque of the motor."""
    time, torque = _columns(folder, "B1714_torque_rec.csv")
    return Record("B1714_torque_rec.csv", {"motor_torque": (time, 1e3 * torque)})


def set_point(folder: Path, place: Path) -> dict[str, float | str]:
    """Overrides that play the smoothed speed of the top drive."""
    recorded, speed = _columns(folder, "B1714_top_rec.csv")
    time = np.arange(0.05, 60.0, 0.05)
    wide = np.interp(time, recorded, speed * RPM)
    width = round(SMOOTHING / 0.05)
    smooth = np.convolve(np.pad(wide, width // 2, "edge"), np.ones(width + 1) / (width + 1), "valid")
    return played(time, smooth, place)


def scene_at(depth: float) -> dict[str, float | str]:
    """Overrides that put the bit at a depth [m] on the last tangent: more pipe and more elements."""
    return {
        "string.sections.4.length": depth - ASSEMBLY,
        "hole.survey.5.depth": depth,
        "numerics.elements": round(80 * depth / 1714.0),
    }


def played(time: Array, speed: Array, place: Path) -> dict[str, float | str]:
    """Overrides that play a set-point of the top drive [rad/s] from a table that they write."""
    file = place / "set_point.csv"
    rows = np.column_stack((np.append(0.0, time), np.append(speed[0], speed)))
    np.savetxt(file, rows, delimiter=",", header="time [s],rotation [rad/s]", comments="")
    gone: dict[str, float | str] = {f"rig.rotation.{key}": "~" for key in ("value", "start", "duration")}
    return gone | {"rig.rotation.shape": "table", "rig.table.file": str(file), "rig.table.spike_window": 0.0}


def _downhole(folder: Path) -> tuple[Array, Array, Array]:
    """Ends of the half seconds after 20 s [s], least and largest downhole speed in each [rad/s]."""
    low, high = (_columns(folder, f"B1714_bit_{name}.csv") for name in ("min", "max"))
    part = (high[0] > STEADY) & (high[0] <= LAST)
    edges = high[0][part]
    return edges, RPM * np.interp(edges, *low), RPM * high[1][part]


def _columns(folder: Path, name: str) -> tuple[Array, Array]:
    """Time [s] and values of a file."""
    time, values = np.loadtxt(folder / name, delimiter=",").T
    return time, values
