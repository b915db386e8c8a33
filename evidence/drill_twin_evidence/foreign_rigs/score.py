# SPDX-License-Identifier: Apache-2.0
"""Score of `fit` and estimator on foreign rigs: `python -m drill_twin_evidence.foreign_rigs.score SEEDS FILE`.

Words after FILE leave out others of their kind: `fit` or `estimate`, `development` or `kept`. A line of JSON for each
rig, seed and way; a campaign that was broken off goes on from there.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import TypedDict

import drill_twin as dt
from drill_twin.core.files.json_files import JsonLines
from drill_twin.core.rig_channels import INSTANT
from drill_twin.core.table import Table
from drill_twin_evidence.foreign_rigs.own_law import own_widths
from drill_twin_evidence.foreign_rigs.rigs import INDICATED, LOAD, LOADS, OVERRIDES, RANGES, RIGS, SCENE, SECONDS, trial
from drill_twin_evidence.proportion import proportion_text
from drill_twin_studies.fitting.posterior import of_law

BIT = "bit_speed"
_SETTLED = 8.0
"""Time from which the bit's speed is counted [s]."""
_MARGIN = 0.01
"""Of the largest speed: a bit at rest has no band."""


class Row(TypedDict):
    """One rig, one seed, fitted or followed: what holds by number, and what is said of the rig and of numbers."""

    rig: str
    seed: int
    way: str
    held: dict[str, bool]
    wide: dict[str, float]
    told: str
    of_number: dict[str, str]


def fitted(name: str, seed: int) -> Row:
    """Fit of the scene to a rig; widths are over those of a fit with the rig's own law."""
    rig_run = trial(name, seed)
    ranges = dict(RANGES) | {"wob": (LOADS[0] * INDICATED, LOADS[1] * INDICATED)}
    found = dt.fit(
        rig_run.record, SCENE, ranges, overrides=_overrides(name), begin=1.0, end=SECONDS - 0.2, rate=10.0, members=32,
        rounds=28, seed=seed,
    )  # fmt: skip
    bands = dict(found.intervals)
    low, high = bands.pop("wob")
    bands[LOAD] = low / INDICATED, high / INDICATED
    own = own_widths(RIGS[name], rig_run)
    return Row(
        rig=name,
        seed=seed,
        way="fit",
        held={key: bands[key][0] <= value <= bands[key][1] for key, value in rig_run.truth.items()},
        wide={key: (bands[key][1] - bands[key][0]) / own[key] for key in rig_run.truth},
        told=found.unexplained,
        of_number={
            key: said
            for key in rig_run.truth
            for said in (*found.undetermined, *found.of_law)
            if key in said or (key == LOAD and "wob" in said)
        },
    )


def followed(name: str, seed: int) -> Row:
    """Estimates over the record of a rig; widths are shares of the ranges."""
    rig_run = trial(name, seed)
    ranges = dict(RANGES) | {LOAD: LOADS}
    options = dt.EstimatorOptions(members=32, horizon=0.0, seed=seed)
    channels = [f"{channel}{'' if RIGS[name].averaged else INSTANT}" for channel in ("torque", "hookload")]
    estimator = dt.Estimator(SCENE, ranges, channels=channels, overrides=_overrides(name), options=options)
    found = list(estimator.follow(rig_run.record))
    bands = {key: (band.low, band.high) for key, band in found[-1].numbers.items()}
    late = [one for one in found if one.time > _SETTLED]
    true = np.interp([one.time for one in late], *rig_run.bit)
    low, high = (np.array([getattr(one.sensors[BIT], end) for one in late]) for end in ("low", "high"))
    margin = _MARGIN * float(np.abs(rig_run.bit[1]).max())
    held = {key: bands[key][0] <= value <= bands[key][1] for key, value in rig_run.truth.items()}
    within = (low - margin <= true) & (true <= high + margin)
    held[BIT] = bool(np.mean(within | np.isnan(low)) >= 0.8)  # a band that is withheld misses nothing
    wide = {key: (bands[key][1] - bands[key][0]) / (ranges[key][1] - ranges[key][0]) for key in rig_run.truth}
    of_number = {key: said for key in ranges for said in of_law(ranges, estimator.scene) if key in said}
    of_number |= {key: f"its band covers {share:.0%} of its range" for key, share in found[-1].untold.items()}
    return Row(rig=name, seed=seed, way="estimate", held=held, wide=wide, told=found[-1].alarm, of_number=of_number)


def _overrides(name: str) -> Mapping[str, float | str]:
    """Changes to the scene; instants need frames that are short against the time from sample to sample."""
    return OVERRIDES if RIGS[name].averaged else dict(OVERRIDES) | {"numerics.frame_rate": 50.0}


def lines(rows: Iterable[Row]) -> list[str]:
    """Tables in Markdown, one for each way, and the shares."""
    shown = []
    for way in ("fit", "estimate"):
        of_way = [row for row in rows if row["way"] == way]
        if not of_way:
            continue
        cells = [
            (f"{row['rig']}, {row['seed']}", "yes" if row["told"] else "no",
             *(_cell(row, key) for key in ({key: 0 for each in of_way for key in each["held"]})))
            for row in of_way
        ]  # fmt: skip
        keys = [key.rpartition(".")[2] for key in {key: 0 for each in of_way for key in each["held"]}]
        shown += [f"{way}:", "", Table(("rig, seed", "told", *keys), cells).markdown(), ""]
        for what, kept in (("rigs by which it was made", False), ("rigs kept back", True)):
            part = [row for row in of_way if RIGS[row["rig"]].kept is kept]
            pairs = [
                (held, bool(row["told"]) or key in row["of_number"])
                for row in part
                for key, held in row["held"].items()
            ]
            if pairs:
                shown.append(
                    f"{what}: bands hold {proportion_text(sum(held for held, _ in pairs), len(pairs))}; held or told "
                    f"{proportion_text(sum(held or told for held, told in pairs), len(pairs))}; rigs told "
                    f"{sum(bool(row['told']) for row in part)} of {len(part)}"
                )
        shown.append("")
    return shown


def _cell(row: Mapping[str, Any], key: str) -> str:
    if key not in row["held"]:
        return ""
    wide = f", {row['wide'][key]:.2g}" if key in row["wide"] else ""
    said = ", said" if key in row["of_number"] else ""
    return ("held" if row["held"][key] else "missed") + wide + said


def main(seeds: list[int], journal: Path, words: Sequence[str] = ()) -> None:
    """Do what the journal lacks, of the ways and rigs that the words name, and print the tables."""
    ways = {"estimate": followed, "fit": fitted}
    wanted = {way: score for way, score in ways.items() if way in words} or ways
    rigs = [name for name, rig in RIGS.items() if ("development" if rig.kept else "kept") not in words]
    file = JsonLines(journal, Row, "foreign rigs", {"ranges": RANGES})
    done = {(row["rig"], row["seed"], row["way"]) for row in file.results}
    for way, score in wanted.items():
        for seed in seeds:
            for name in rigs:
                if (name, seed, way) not in done:
                    file.add(score(name, seed))
    print("\n".join(lines(file.results)))


if __name__ == "__main__":
    main([int(seed) for seed in sys.argv[1].split(",")], Path(sys.argv[2]), sys.argv[3:])
