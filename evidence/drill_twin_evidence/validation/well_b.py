# SPDX-License-Identifier: Apache-2.0
"""Well B (Aarsnes and Shor 2018, Fig. 15 and 16): two start-ups off bottom in a deviated well."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, NamedTuple

import numpy as np
from scipy import optimize

from drill_twin.api import Ensemble, Posterior, Record, fit, load_scene
from drill_twin.core.arrays import Array
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at
from drill_twin_evidence.validation.comparison import Comparison, Trace, Validation, cycle_length, rms

RPM = np.pi / 30.0
DEPTH, DEEPER = 1714.0, 2235.0
"""Depth of the bit in the two start-ups [m]."""
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
LEAD = 12.0
"""Time before the start-up in which the string is wound, where torsion is locked in it [s]."""
SPREAD, NEIGHBOURS = 0.01, 8
"""Standard deviation of the numbers of neighbours, over the numbers of the scene; stick-slip is sensitive to them."""
STIFF = {"rig.top_drive.proportional_gain": 1e6, "rig.top_drive.integral_gain": 1e7}
"""Gains with which the top drive follows its recorded speed [N m s/rad, N m/rad]."""
SMOOTHING = 0.5
"""Width of the mean of the recorded speed of the top drive [s]."""
ABOUT = (
    "The top drive follows its recorded speed; its inertia is the published one. Friction of pipe and assembly, "
    "damping, drag, friction of the drive and the diameter of an assembly of one size were fitted to torque and "
    "downhole speed of 0 to 45 s. All of it is a fit, at these elements and this step. The figure has the largest "
    "downhole speed measured in each half second after 20 s."
)


class Channels(NamedTuple):
    """A run beside the record: depth of the bit [m]; time [s], motor torque measured and computed [N m], bit speed
    [rad/s], each of shape (T,).
    """

    depth: float

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
            scene = load_scene("well_b", set_point(folder, Path(place)) | search(folder, [scene]))
        own = np.array([number_at(scene, key) or 0.0 for key in FREE])
        spread = 1.0 + SPREAD * np.random.default_rng(1).standard_normal((NEIGHBOURS, len(FREE)))
        values = np.vstack([own, own * spread])
        run, *near = runs_of(folder, scene, dict(zip(FREE, values.T.tolist(), strict=True)))
    error = float(np.median([comparisons(folder, other)[0].computed for other in near]))
    rows = [
        *comparisons(folder, run),
        Comparison("rms error, median of 8 draws of its numbers (normal, deviation 1 %)", "fit", None, error, 0.5),
    ]
    return Validation("well_b", scene.name, ABOUT, rows, traces(folder, run), LAST)


def traces(folder: Path, run: Channels) -> list[Trace]:
    """Torque, and downhole speed with the largest measured one of each half second after 20 s."""
    _, high, edges = _downhole(folder, run.depth)
    middle = np.where(run.time > STEADY, np.interp(run.time, edges - 0.25, high), np.nan)
    return [
        Trace("motor torque [N m]", run.time, run.measured, run.torque),
        Trace("downhole speed [rad/s]", run.time, middle, run.bit),
    ]


def runs_of(folder: Path, scene: Scene, vary: Mapping[str, Sequence[float]], *, lead: float = 0.0) -> list[Channels]:
    """Runs that differ in numbers, beside the record.

    Args:
        folder: Folder of the record.
        scene: The scene.
        vary: Values of each run by key [SI units].
        lead: Time that the set-point has before the record begins [s].
    """
    depth = scene.hole.survey[-1].depth
    runs = Ensemble(scene, vary, zipped=True).run(lead + LAST, outputs="channels", mark_rate=RATE)
    part = runs["time"] > lead + 0.5 / RATE
    time = runs["time"][part] - lead
    measured = torque_record(folder, depth).at("motor_torque", time)
    pairs = zip(runs["motor_torque"], runs["bit_speed"], strict=True)
    return [Channels(depth, time, measured, torque[part], bit[part]) for torque, bit in pairs]


def comparisons(folder: Path, run: Channels, kind: Literal["fit", "prediction"] = "fit") -> list[Comparison]:
    """Error of the torque, and features of torque and downhole speed."""
    steady, start = run.time > STEADY, run.time < STEADY
    low, high, edges = _downhole(folder, run.depth)
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
        Comparison("rms error of the torque over its deviation", kind, None, deviation, 0.5),
        *(Comparison(what, kind, measured, own, aim) for (what, aim), (measured, own) in pairs.items()),
    ]


def misfit(folder: Path, run: Channels) -> float:
    """Error of the torque, and by what share of their aims features exceed two thirds of them; infinite for a run that
    failed.
    """
    if not np.isfinite(run.torque).all():
        return math.inf
    error, *features = comparisons(folder, run)
    return error.computed + sum(max(0.0, abs(feature.difference) / feature.aim - 2.0 / 3.0) for feature in features)


def search(folder: Path, scenes: Sequence[Scene], free: Mapping[str, tuple[float, float]] = FREE) -> dict[str, float]:
    """Numbers of least misfit by differential evolution (Storn and Price 1997), a generation an ensemble.

    Args:
        folder: Folder of the record.
        scenes: A scene for each start-up that is fitted to; the search begins with the numbers of the first.
        free: Ranges of the numbers [SI units].
    """
    own = np.array([number_at(scenes[0], key) for key in free])

    def misfits(values: Array) -> Array:
        vary = {key: row.tolist() for key, row in zip(free, values, strict=True)}
        each = [[misfit(folder, run) for run in runs_of(folder, scene, vary)] for scene in scenes]
        total: Array = np.sum(each, axis=0)
        return total

    best = optimize.differential_evolution(
        misfits, list(free.values()), x0=own, seed=1, maxiter=GENERATIONS,
        popsize=-(-POPULATION // len(free)), vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    return dict(zip(free, best.x.tolist(), strict=True))


def fitted(folder: Path, scene: Scene) -> Posterior:
    """Fit to the motor torque near the numbers of the scene."""
    own = {key: number_at(scene, key) or 0.0 for key in FREE}
    ranges = {key: f"{(1.0 - NEAR) * value:.6g}..{(1.0 + NEAR) * value:.6g}" for key, value in own.items()}
    return fit(torque_record(folder), scene, ranges, end=LAST, rate=5.0, members=16, rounds=6, effective=16)


def torque_record(folder: Path, depth: float = DEPTH, kind: Literal["rec", "sim"] = "rec") -> Record:
    """Torque of the motor, recorded or of the published model, at 100 Hz.

    The file has the corners of the line drawn through it, so nothing is missing between them.
    """
    name = f"B{depth:.0f}_torque_{kind}.csv"
    drawn, torque = columns(folder, name)
    time = np.arange(drawn[0], drawn[-1], 0.01)
    return Record(name, {"motor_torque": (time, 1e3 * np.interp(time, drawn, torque))})


def set_point(folder: Path, place: Path, depth: float = DEPTH, wound: float = 0.0) -> dict[str, float | str]:
    """Overrides that put the bit at a depth, and by which the top drive follows the smoothed speed recorded there.

    Args:
        folder: Folder of the record.
        place: Folder into which the table of the speed is written.
        depth: Depth of the bit [m].
        wound: Turn of the top before the start-up, half of which is taken back: where friction is uniform, the torque
            at the top is zero again, and torsion stays locked below [rad]. The start-up then begins after `LEAD`.
    """
    recorded, speed = columns(folder, f"B{depth:.0f}_top_rec.csv")
    time = np.arange(0.05, 60.0, 0.05)
    wide = np.interp(time, recorded, speed * RPM)
    width = round(SMOOTHING / 0.05)
    smooth = np.convolve(np.pad(wide, width // 2, "edge"), np.ones(width + 1) / (width + 1), "valid")
    if wound:
        before = np.arange(0.05, LEAD, 0.05)
        turn = wound / 3.0 * ((before > 1.0) & (before <= 4.0)) - wound / 4.0 * ((before > 5.0) & (before <= 7.0))
        time, smooth = np.append(before, LEAD + time), np.append(turn, smooth)
    return scene_at(depth) | played(time, smooth, place)


def scene_at(depth: float) -> dict[str, float | str]:
    """Overrides that put the bit at a depth [m] on the last tangent: more pipe and more elements."""
    return {
        "string.sections.1.length": depth - ASSEMBLY,
        "hole.survey.5.depth": depth,
        "effects.wall_friction.intervals.0.bottom": depth - ASSEMBLY,
        "numerics.elements": round(80 * depth / DEPTH),
    }


def played(time: Array, speed: Array, place: Path) -> dict[str, float | str]:
    """Overrides by which the top drive follows a speed [rad/s], from a table that they write."""
    file = place / "set_point.csv"
    rows = np.column_stack((np.append(0.0, time), np.append(speed[0], speed)))
    np.savetxt(file, rows, delimiter=",", header="time [s],rotation [rad/s]", comments="")
    gone: dict[str, float | str] = {f"rig.rotation.{key}": "~" for key in ("value", "start", "duration")}
    return gone | STIFF | {"rig.rotation.shape": "table", "rig.table.file": str(file), "rig.table.spike_window": 0.0}


def _downhole(folder: Path, depth: float) -> tuple[Array, Array, Array]:
    """Least and largest downhole speed in the half seconds after 20 s [rad/s], and their ends [s]."""
    low, high = (columns(folder, f"B{depth:.0f}_bit_{name}.csv") for name in ("min", "max"))
    part = (high[0] > STEADY) & (high[0] <= LAST)
    edges = high[0][part]
    return RPM * np.interp(edges, *low), RPM * high[1][part], edges


def columns(folder: Path, name: str) -> tuple[Array, Array]:
    """Time [s] and values of a file."""
    time, values = np.loadtxt(folder / name, delimiter=",").T
    return time, values
