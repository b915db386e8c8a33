# SPDX-License-Identifier: Apache-2.0
"""Well B with the bit at 1,714 m (Aarsnes and Shor 2018, Fig. 15): a start-up off bottom in a deviated well."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy import optimize

from drill_twin.api import Ensemble, Posterior, Record, fit, load_scene
from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at
from drill_twin_evidence.validation.comparison import Comparison, Trace, Validation, cycle_length, rms

RPM = np.pi / 30.0
ASSEMBLY = 259.08
"""Length of the bottom-hole assembly [m]."""
LAST = 45.0
"""End of the comparison [s]."""
RATE = 25.0
STEADY = 20.0
"""Start of the steady stick-slip [s]."""
FREE = {
    "string.sections.0.outer_diameter": (0.165, 0.205),
    "effects.wall_friction.coefficient": (0.45, 1.0),
    "effects.wall_friction.sliding": (0.1, 0.4),
    "effects.wall_friction.decay": (5.0, 50.0),
    "effects.wall_friction.exponent": (1.0, 7.0),
    "effects.wall_friction.intervals.0.coefficient": (0.15, 0.45),
    "effects.internal_damping.torsion_time": (1e-4, 8e-3),
    "effects.drag.rotary": (0.001, 0.1),
    "rig.top_drive.damping": (0.0, 300.0),
}
"""Ranges of the fit [SI units]."""
NEAR = 0.1
"""Half width of the ranges of the blind test's fit, over the numbers of the scene."""
GENERATIONS, POPULATION = 30, 32
SPREAD, NEIGHBOURS = 0.01, 8
"""Standard deviation of the numbers of neighbours, over the numbers of the scene; stick-slip is sensitive to them."""
STIFF = {"rig.top_drive.proportional_gain": 1e6, "rig.top_drive.integral_gain": 1e7}
"""Gains with which the top drive follows its recorded speed [N m s/rad, N m/rad]."""
SMOOTHING = 0.5
"""Width of the mean of the recorded speed of the top drive [s]."""
ABOUT = (
    "The top drive follows its recorded speed; its inertia is the published one. Friction of pipe and assembly, "
    "damping, drag, friction of the drive and the diameter of an assembly of one size were fitted to torque and "
    "downhole speed of 0 to 45 s: all of it is a fit, at these elements and this step. Of the measured downhole speed "
    "the largest of each half second after 20 s is drawn."
)


class Channels(NamedTuple):
    """A run beside the record: time [s], motor torque measured and computed [N m], bit speed [rad/s]; shape (T,)."""

    time: Array
    measured: Array
    torque: Array
    bit: Array


def validate(folder: Path, *, refit: bool) -> Validation:
    """Motor torque and downhole speed over the first 45 s.

    Args:
        folder: Folder of the record.
        refit: Search better numbers, beginning with those of the scene: about 1,100 runs.
    """
    with TemporaryDirectory() as place:
        scene = load_scene("well_b", set_point(folder, Path(place)))
        if refit:
            scene = load_scene("well_b", set_point(folder, Path(place)) | search(folder, scene))
        own = np.array([number_at(scene, key) or 0.0 for key in FREE])
        spread = 1.0 + SPREAD * np.random.default_rng(1).standard_normal((NEIGHBOURS, len(FREE)))
        values = np.vstack([own, own * spread])
        run, *near = runs_of(folder, scene, dict(zip(FREE, values.T.tolist(), strict=True)))
    _, high, edges = _downhole(folder)
    middle = np.where(run.time > STEADY, np.interp(run.time, edges - 0.25, high), np.nan)
    traces = [
        Trace("motor torque [N m]", run.time, run.measured, run.torque),
        Trace("downhole speed [rad/s]", run.time, middle, run.bit),
    ]
    error = float(np.median([comparisons(folder, other)[0].computed for other in near]))
    rows = [
        *comparisons(folder, run),
        Comparison("rms error, median of 8 draws of its numbers (normal, deviation 1 %)", "fit", None, error, 0.5),
    ]
    return Validation("well_b", scene.name, ABOUT, rows, traces, LAST)


def runs_of(folder: Path, scene: Scene, vary: Mapping[str, Sequence[float]]) -> list[Channels]:
    """Runs that differ in numbers, beside the record.

    Args:
        folder: Folder of the record.
        scene: The scene.
        vary: Values of each run by key [SI units].
    """
    runs = Ensemble(scene, vary, zipped=True).run(LAST, outputs="channels", mark_rate=RATE)
    measured = torque_record(folder).at("motor_torque", runs["time"])
    pairs = zip(runs["motor_torque"], runs["bit_speed"], strict=True)
    return [Channels(runs["time"], measured, torque, bit) for torque, bit in pairs]


def comparisons(folder: Path, run: Channels) -> list[Comparison]:
    """Error of the torque, and features of torque and downhole speed."""
    steady, start = run.time > STEADY, run.time < STEADY
    low, high, edges = _downhole(folder)
    ends = [np.searchsorted(run.time, (edge - 0.5, edge), "right") for edge in edges]
    computed = np.array([(run.bit[i:j].min(), run.bit[i:j].max()) for i, j in ends])
    deviation = rms(run.torque - run.measured) / float(run.measured.std())
    torques = (run.measured, run.torque)
    pairs = {
        ("break-off torque [N m]", 0.1): [float(x[start].max()) for x in torques],
        ("period of the torque after 20 s [s]", 0.05): [cycle_length(x[steady], 1.0 / RATE, 2.5, 6.0) for x in torques],
        ("range of the downhole speed after 20 s [rad/s]", 0.15): [
            float(high.max() - low.min()),
            float(np.ptp(computed)),
        ],
    }
    return [
        Comparison("rms error of the torque over its deviation", "fit", None, deviation, 0.5),
        *(Comparison(what, "fit", measured, own, aim) for (what, aim), (measured, own) in pairs.items()),
    ]


def misfit(folder: Path, run: Channels) -> float:
    """Error of the torque, and by how much features exceed two thirds of their aims; infinite for a run that failed."""
    if not np.isfinite(run.torque).all():
        return math.inf
    error, *features = comparisons(folder, run)
    return error.computed + sum(max(0.0, abs(of.difference) - of.aim / 1.5) for of in features)


def search(folder: Path, scene: Scene) -> dict[str, float]:
    """Numbers of least misfit by differential evolution (Storn and Price 1997), a generation an ensemble."""
    own = np.array([number_at(scene, key) for key in FREE])

    def misfits(values: Array) -> Array:
        vary = {key: row.tolist() for key, row in zip(FREE, values, strict=True)}
        return np.array([misfit(folder, run) for run in runs_of(folder, scene, vary)])

    best = optimize.differential_evolution(
        misfits, list(FREE.values()), x0=own, seed=1, maxiter=GENERATIONS,
        popsize=-(-POPULATION // len(FREE)), vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    return dict(zip(FREE, best.x.tolist(), strict=True))


def fitted(folder: Path, scene: Scene) -> Posterior:
    """Fit to the motor torque near the numbers of the scene."""
    own = {key: number_at(scene, key) or 0.0 for key in FREE}
    ranges = {key: f"{(1.0 - NEAR) * value:.6g}..{(1.0 + NEAR) * value:.6g}" for key, value in own.items()}
    return fit(torque_record(folder), scene, ranges, end=LAST, rate=5.0, members=16, rounds=6, effective=16)


def torque_record(folder: Path) -> Record:
    """Recorded torque of the motor."""
    time, torque = _columns(folder, "B1714_torque_rec.csv")
    return Record("B1714_torque_rec.csv", {"motor_torque": (time, 1e3 * torque)})


def set_point(folder: Path, place: Path) -> dict[str, float | str]:
    """Overrides by which the top drive follows its smoothed speed."""
    recorded, speed = _columns(folder, "B1714_top_rec.csv")
    time = np.arange(0.05, 60.0, 0.05)
    wide = np.interp(time, recorded, speed * RPM)
    width = round(SMOOTHING / 0.05)
    smooth = np.convolve(np.pad(wide, width // 2, "edge"), np.ones(width + 1) / (width + 1), "valid")
    return played(time, smooth, place)


def scene_at(depth: float) -> dict[str, float | str]:
    """Overrides that put the bit at a depth [m] on the last tangent: more pipe and more elements."""
    return {
        "string.sections.1.length": depth - ASSEMBLY,
        "hole.survey.5.depth": depth,
        "effects.wall_friction.intervals.0.bottom": depth - ASSEMBLY,
        "numerics.elements": round(80 * depth / 1714.0),
    }


def played(time: Array, speed: Array, place: Path) -> dict[str, float | str]:
    """Overrides by which the top drive follows a speed [rad/s], from a table that they write."""
    file = place / "set_point.csv"
    rows = np.column_stack((np.append(0.0, time), np.append(speed[0], speed)))
    np.savetxt(file, rows, delimiter=",", header="time [s],rotation [rad/s]", comments="")
    gone: dict[str, float | str] = {f"rig.rotation.{key}": "~" for key in ("value", "start", "duration")}
    return gone | STIFF | {"rig.rotation.shape": "table", "rig.table.file": str(file), "rig.table.spike_window": 0.0}


def _downhole(folder: Path) -> tuple[Array, Array, Array]:
    """Least and largest downhole speed in the half seconds after 20 s [rad/s], and their ends [s]."""
    low, high = (_columns(folder, f"B1714_bit_{name}.csv") for name in ("min", "max"))
    part = (high[0] > STEADY) & (high[0] <= LAST)
    edges = high[0][part]
    return RPM * np.interp(edges, *low), RPM * high[1][part], edges


def _columns(folder: Path, name: str) -> tuple[Array, Array]:
    """Time [s] and values of a file."""
    time, values = np.loadtxt(folder / name, delimiter=",").T
    return time, values
