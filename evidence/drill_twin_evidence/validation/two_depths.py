# SPDX-License-Identifier: Apache-2.0
"""Two start-ups of Well B: fitted to either, predicting the other, and fitted to both (evidence/docs/blind_test.md).

`python -m drill_twin_evidence.validation.two_depths` prints the verdict on the blind prediction, each fit beside both
records, and what differs at 2,235 m where one group of the numbers fitted at 1,714 m is freed there.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from drill_twin.api import load_scene
from drill_twin.cli.emit import write_files
from drill_twin.core.table import Table
from drill_twin.scene import Scene
from drill_twin_evidence.validation import blind_test, well_b
from drill_twin_evidence.validation.comparison import Comparison, Validation, data_folder
from drill_twin_evidence.validation.page import figure, table
from drill_twin_evidence.validation.well_b import DEEPER, DEPTH, LAST, LEAD, Channels

PREDICTION = Path(__file__).parents[2] / "docs" / "well_b_2235.csv"
"""The prediction as it was written down."""
FREE = {**well_b.FREE, "hole.radius": (0.112, 0.156)}
"""Ranges of the fits; the hole, whose diameter is not published, limits how far the string rolls up its wall."""
DRIVE = {"rig.top_drive.inertia": (0.0, 6000.0)}
"""Range of the drive's inertia [kg m^2]."""
GROUPS: Mapping[str, Sequence[str]] = {
    "friction along the string": (
        "effects.wall_friction.coefficient",
        "effects.wall_friction.sliding",
        "effects.wall_friction.intervals.0.coefficient",
    ),
    "assembly": ("string.sections.0.outer_diameter",),
    "drive": ("rig.top_drive.damping", "rig.top_drive.inertia"),
}
"""Numbers that are freed together at 2,235 m."""
DRAWS = 16
"""Draws of a group (Sobol points), a run each."""
TURNS = (-8.0, -4.0, 4.0, 8.0)
"""Turns of the top by which torsion is locked in the string [rad]: see `well_b.set_point`."""
HEADS = ("numbers", "start-up", "rms error", "break-off [kN m]", "period [s]", "downhole range [rad/s]", "aims met")


class Fit(NamedTuple):
    """Numbers fitted to start-ups.

    Attributes:
        depths: Depths of these start-ups [m].
        numbers: Those that differ from the scene's, by key [SI units].
        elements: Elements at 1,714 m; the step is 0.8 s over their number.
    """

    depths: Sequence[float]
    numbers: Mapping[str, float]
    elements: int = 80


DEEP = {
    "string.sections.0.outer_diameter": 0.1636,
    "effects.wall_friction.coefficient": 0.6909,
    "effects.wall_friction.sliding": 0.2486,
    "effects.wall_friction.decay": 23.8,
    "effects.wall_friction.exponent": 1.308,
    "effects.wall_friction.intervals.0.coefficient": 0.6108,
    "effects.internal_damping.torsion_time": 0.0003934,
    "effects.drag.rotary": 0.06506,
    "rig.top_drive.damping": 260.1,
    "hole.radius": 0.139,
}
BOTH = {
    "string.sections.0.outer_diameter": 0.17411049869156514,
    "effects.wall_friction.coefficient": 1.0226643101335273,
    "effects.wall_friction.sliding": 0.29275235620274315,
    "effects.wall_friction.decay": 7.3292093866507955,
    "effects.wall_friction.exponent": 4.570401415482764,
    "effects.wall_friction.intervals.0.coefficient": 0.2164003391868287,
    "effects.internal_damping.torsion_time": 0.004816487201414555,
    "effects.drag.rotary": 0.22301658709974506,
    "rig.top_drive.damping": 342.07709972684006,
    "hole.radius": 0.14337143592533788,
}
"""With all digits, as stick-slip is sensitive to them."""
FITS: Mapping[str, Fit] = {
    "fit at 1,714 m": Fit((DEPTH,), {}),
    "fit at 2,235 m": Fit((DEEPER,), DEEP),
    "fit to both": Fit((DEPTH, DEEPER), BOTH),
    "fit to both, 40 elements": Fit((DEPTH, DEEPER), BOTH, 40),
}
"""The first is that of the scene itself; the others were searched by differential evolution at 40 elements."""


def scene_of(folder: Path, place: Path, depth: float, fit: Fit, wound: float = 0.0) -> Scene:
    """Scene of a start-up.

    Args:
        folder: Folder of the record.
        place: Folder into which the set-point is written.
        depth: Depth of the bit [m].
        fit: Its numbers.
        wound: Turn of the top before the start-up, as of `well_b.set_point` [rad].
    """
    cells = {"numerics.elements": round(fit.elements * depth / DEPTH), "numerics.step": 0.8 / fit.elements}
    return load_scene("well_b", {**well_b.set_point(folder, place, depth, wound), **fit.numbers, **cells})


def run_of(folder: Path, depth: float, fit: Fit, wound: float = 0.0) -> Channels:
    """Run of a start-up beside its record; arguments as of `scene_of`."""
    with TemporaryDirectory() as place:
        scene = scene_of(folder, Path(place), depth, fit, wound)
        vary = {"seed": [scene.numerics.seed]}
        return well_b.runs_of(folder, scene, vary, lead=LEAD if wound else 0.0)[0]


def refitted(folder: Path, fit: Fit) -> dict[str, float]:
    """Numbers of a fit after a search that begins with them."""
    with TemporaryDirectory() as place:
        scenes: list[Scene] = []
        for depth in fit.depths:
            own = Path(place) / f"{depth:.0f}"
            own.mkdir()
            scenes.append(scene_of(folder, own, depth, fit))
        return well_b.search(folder, scenes, FREE)


def row(name: str, run: Channels, rows: Sequence[Comparison]) -> tuple[str, ...]:
    """Cells of a run: its error over the record's deviation, and features, computed for measured."""
    error, torque, period, speed = rows
    pairs = [(f"{scale * one.computed:.3g} for {scale * (one.measured or 0.0):.3g}")
             for one, scale in ((torque, 1e-3), (period, 1.0), (speed, 1.0))]  # fmt: skip
    met = sum(one.met for one in (torque, period, speed))
    return (name, f"{run.depth:,.0f} m, {error.kind}", f"{error.computed:.0%}", *pairs, f"{met} of 3")


def fits_table(folder: Path) -> Table:
    """Each fit beside both records."""
    cells = []
    for name, fit in FITS.items():
        for depth in (DEPTH, DEEPER):
            run = run_of(folder, depth, fit)
            cells.append(
                row(name, run, well_b.comparisons(folder, run, "fit" if depth in fit.depths else "prediction"))
            )
    return Table(HEADS, cells)


def freed(folder: Path) -> Iterator[tuple[str, ...]]:
    """Rows at 2,235 m with the numbers fitted at 1,714 m, one group of them chosen from `DRAWS` by its misfit there."""
    fit = FITS["fit at 1,714 m"]
    for name, keys in GROUPS.items():
        low, high = np.transpose([(FREE | DRIVE)[key] for key in keys])
        values = low + (high - low) * qmc.Sobol(len(keys), seed=1).random(DRAWS)
        with TemporaryDirectory() as place:
            scene = scene_of(folder, Path(place), DEEPER, fit)
            runs = well_b.runs_of(folder, scene, dict(zip(keys, values.T.tolist(), strict=True)))
        best = int(np.argmin([well_b.misfit(folder, run) for run in runs]))
        chosen = ", ".join(f"{value:.3g}" for value in values[best])
        yield row(f"{name}: {chosen}", runs[best], well_b.comparisons(folder, runs[best]))
    for turn in TURNS:
        run = run_of(folder, DEEPER, fit, turn)
        yield row(f"torsion locked by a turn of {turn:g} rad", run, well_b.comparisons(folder, run, "prediction"))


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, metavar="DIR", help="folder with well_b/; else that of DRILL_TWIN_DATA")
    parser.add_argument("--refit", metavar="FIT", choices=list(FITS), help="search better numbers for it, print them")
    parser.add_argument("--freed", action="store_true", help="free one group of numbers at 2,235 m, too: minutes")
    parser.add_argument("--figure", type=Path, metavar="DIR", help="draw both records with the joint fit")
    given = parser.parse_args()
    folder = data_folder(given.data) / "well_b"
    if given.refit:
        print(refitted(folder, FITS[given.refit]))
        return
    verdict = blind_test.verdict(folder, PREDICTION)
    print(table(Validation("well_b at 2,235 m", "well_b", "", verdict, [], LAST)).markdown())
    print(fits_table(folder).markdown())
    if given.freed:
        print(Table(HEADS, freed(folder)).markdown())
    if given.figure:
        fit = FITS["fit to both"]
        traces = [
            trace._replace(label=trace.label.split(" ", 1)[1].replace(" [", f" at {depth:g} m ["))
            for depth in (DEPTH, DEEPER)
            for trace in well_b.traces(folder, run_of(folder, depth, fit))
        ]
        shown = Validation("well_b, fit to both", "well_b", "", (), traces, LAST)
        write_files(given.figure, {"well_b_two_depths.png": figure(shown)})


if __name__ == "__main__":
    main()
