# SPDX-License-Identifier: Apache-2.0
"""Share of random twins whose hidden numbers lie in the 90 % intervals of a fit: `make fit-coverage`.

Friction and load are drawn from the prior, ends of the ranges included, by a fresh seed each time, which is kept with
the result: nothing can have been chosen by them. Likelihood and draws are those of `fit`; the runs are those of the
stepper of the foreign rigs with the law of the scene, for the record and for the fit alike, at a tenth of the cost.
A line of JSON for each twin is kept; a campaign that was broken off goes on from there.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from typing_extensions import TypedDict

from drill_twin.core.arrays import Array
from drill_twin.core.files.json_files import JsonLines
from drill_twin.core.table import Table
from drill_twin_evidence.foreign_rigs.own_law import OWN_RANGES, own_fit
from drill_twin_evidence.foreign_rigs.rigs import (
    INDICATED,
    LOAD,
    RIGS,
    SURFACE,
    mechanics_of,
    sampled,
    with_noise,
)
from drill_twin_evidence.proportion import proportion_text
from drill_twin_studies.fitting.likelihood import of_series
from drill_twin_studies.fitting.sampling import in_ranges

RIG = RIGS["mild exponential"]
WAYS = {"surface": SURFACE, "with a sub": (*SURFACE, "bit_speed")}
"""Channels of the record by the way of measuring."""
NOISE, STEP = 0.01, 2.5e-3
END = 0.1
"""Part of a range at each of its ends."""


class Twin(TypedDict):
    """Fits to one twin: positions of its numbers in the ranges, and by way whether the intervals hold."""

    seed: int
    position: dict[str, float]
    inside: dict[str, dict[str, bool]]
    runs: dict[str, int]
    wide: dict[str, bool]


def cover(seed: int) -> Twin:
    """Fit one random twin each way; tells which intervals hold the hidden number."""
    generator = np.random.default_rng(seed)
    cube = generator.uniform(size=(1, len(OWN_RANGES)))
    hidden = in_ranges(cube, OWN_RANGES)[0]
    numbers = dict(zip(OWN_RANGES, hidden.tolist(), strict=True))
    clean = sampled(RIG, mechanics_of(RIG, numbers), numbers[LOAD] * INDICATED, STEP)[1]
    record = with_noise(clean, NOISE, generator)
    position = dict(zip(OWN_RANGES, cube[0].tolist(), strict=True))
    twin = Twin(seed=seed, position=position, inside={}, runs={}, wide={})
    for way, channels in WAYS.items():
        measured = {channel: record[channel] for channel in channels}

        def likelihood(runs: Mapping[str, Array], measured: Mapping[str, Array] = measured) -> Array:
            return of_series(measured, runs, len(OWN_RANGES))

        values, found = own_fit(RIG, channels, likelihood, seed % 2**31, STEP)
        low, high = in_ranges(found.intervals, OWN_RANGES)
        held = (low <= hidden) & (hidden <= high)
        twin["inside"][way] = dict(zip(OWN_RANGES, held.tolist(), strict=True))
        twin["runs"][way], twin["wide"][way] = len(values), found.power < 1.0
    return twin


def lines(twins: Sequence[Twin]) -> list[str]:
    """The shares as lines of Markdown; near the ends: hidden numbers in the lowest or highest `END` of their range."""
    rows = []
    for way in WAYS:
        for key in OWN_RANGES:
            held = [twin["inside"][way][key] for twin in twins]
            ends = [twin["inside"][way][key] for twin in twins if abs(twin["position"][key] - 0.5) > 0.5 - END]
            rows.append((way, key, proportion_text(sum(held), len(held)), proportion_text(sum(ends), len(ends))))
    table = Table(("channels", "number", "90 % intervals that hold", "near the ends of the range"), rows).markdown()
    costs = [
        f"{way}: {np.mean([twin['runs'][way] for twin in twins]):.0f} runs a fit; "
        f"{sum(twin['wide'][way] for twin in twins)} ended with draws wider than the record allows"
        for way in WAYS
    ]
    return [table, "", *costs]


def main(twins: int, journal: Path) -> None:
    """Fit as many twins as the journal lacks, and print the shares."""
    setup = {"ranges": OWN_RANGES, "ways": WAYS, "noise": NOISE, "step": STEP}
    file = JsonLines(journal, Twin, "fit coverage", setup)
    while len(file.results) < twins:
        file.add(cover(int(np.random.SeedSequence().generate_state(1, np.uint64)[0] >> 1)))
    print("\n".join(lines(file.results)))


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
