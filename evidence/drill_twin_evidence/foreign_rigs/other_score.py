# SPDX-License-Identifier: Apache-2.0
"""Score of the estimator on rigs of other kinds: `python -m drill_twin_evidence.foreign_rigs.other_score SEEDS FILE`.

A window is right where the band of the bit's speed holds, or is withheld. Names after FILE choose kinds, and
the ten rigs of `drill_twin_evidence.foreign_rigs.rigs`, followed for as long. A line of JSON for each kind and seed; a
campaign that was broken off goes on from there.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import TypedDict

import drill_twin as dt
from drill_twin.core.files.json_files import JsonLines
from drill_twin.core.rig_channels import INSTANT
from drill_twin.core.table import Table
from drill_twin_evidence.foreign_rigs import rigs
from drill_twin_evidence.foreign_rigs.other_rigs import KINDS, SECONDS, Recorded, recorded

_SETTLED = 15.0
"""Time from which windows are counted [s]."""
_MARGIN = 0.01
"""Of the largest speed of the bit: a bit at rest has no band."""


class Row(TypedDict):
    """One kind and seed: shares of the windows, and what is said at the end."""

    kind: str
    seed: int
    held: float
    withheld: float
    wrong: float
    alarm: float
    first: float
    last: str
    remembered: str
    numbers: dict[str, bool]


def _record(name: str, seed: int) -> tuple[Recorded, dict[str, float | str], Sequence[str]]:
    """Record, changes to the scene, and channels."""
    if name in KINDS:
        of, averaged = recorded(name, seed), KINDS[name].averaged
        changes: dict[str, float | str] = {"rig.rotation.value": KINDS[name].machine.get("speed", 2.5)}
    else:
        trial, averaged = rigs.trial(name, seed, seconds=SECONDS), rigs.RIGS[name].averaged
        of, changes = Recorded(trial.record, trial.truth, trial.bit[1][99::100]), {}
    if not averaged:
        changes["numerics.frame_rate"] = 50.0
    return of, changes, [f"{channel}{'' if averaged else INSTANT}" for channel in ("torque", "hookload")]


def followed(name: str, seed: int) -> Row:
    """Estimates over the record of a rig."""
    of, changes, channels = _record(name, seed)
    options = dt.EstimatorOptions(members=24, horizon=0.0, seed=seed)
    ranges = dict(rigs.RANGES) | {rigs.LOAD: rigs.LOADS}
    overrides = dict(rigs.OVERRIDES) | changes
    estimator = dt.Estimator(rigs.SCENE, ranges, channels=channels, overrides=overrides, options=options)
    found = list(estimator.follow(of.record))
    true = of.bit[: len(found)]
    low, high = (np.array([getattr(one.sensors["bit_speed"], end) for one in found]) for end in ("low", "high"))
    margin = _MARGIN * float(np.abs(true).max())
    withheld, late = np.isnan(low), np.array([one.time for one in found]) > _SETTLED
    held = (low - margin <= true) & (true <= high + margin)
    alarm, last = np.array([bool(one.alarm) for one in found]), found[-1]
    return Row(
        kind=name,
        seed=seed,
        held=float(held[late].mean()),
        withheld=float(withheld[late].mean()),
        wrong=float((~held & ~withheld)[late].mean()),
        alarm=float(alarm[late].mean()),
        first=next((one.time for one in found if one.alarm), float("nan")),
        last=last.alarm,
        remembered=last.remembered,
        numbers={key: last.numbers[key].low <= value <= last.numbers[key].high for key, value in of.truth.items()},
    )


def lines(rows: Iterable[Row]) -> list[str]:
    """Table in Markdown."""
    heads = ("rig, seed", "held", "withheld", "neither", "first told", "at the end", "numbers held")
    cells = [
        (f"{row['kind']}, {row['seed']}", *(f"{row[key]:.0%}" for key in ("held", "withheld", "wrong")),
         f"{row['first']:.0f} s" if row["first"] == row["first"] else "no", "alarm" if row["last"] else
         "told of earlier" if row["remembered"] else "", f"{sum(row['numbers'].values())} of {len(row['numbers'])}")
        for row in rows
    ]  # fmt: skip
    return [Table(heads, cells).markdown()]


def main(seeds: Sequence[int], journal: Path, names: Sequence[str] = ()) -> None:
    """Follow what the journal lacks, and print the table."""
    file: Any = JsonLines(journal, Row, "other rigs", {"ranges": rigs.RANGES})
    done = {(row["kind"], row["seed"]) for row in file.results}
    for seed in seeds:
        for name in names or KINDS:
            if (name, seed) not in done:
                file.add(followed(name, seed))
    print("\n".join(lines(file.results)))


if __name__ == "__main__":
    main([int(seed) for seed in sys.argv[1].split(",")], Path(sys.argv[2]), sys.argv[3:])
