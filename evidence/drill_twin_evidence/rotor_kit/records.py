# SPDX-License-Identifier: Apache-2.0
"""The record of the rotor kit: vectors of four probes at 1,005 rpm, and the conditions they belong to."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from drill_twin_evidence.rotor_kit.elements import Complex, Real

Integers = NDArray[np.int64]

CREDIT = (
    "M-Nouioua/rk4-rotor-unbalance-estimation, Copyright (c) 2026 Mourad Nouioua, MIT for code and artefacts",
    "raw records CC BY 4.0, Zenodo 10.5281/zenodo.23152815",
)
PROBES = ("p1x", "p1y", "p2x", "p2y")
COUNTED = (2, 3)  # p2x and p2y, in which the issue counts
MICROMETRES_IN_A_MIL = 25.4
FITTED = ("BASE", "A007", "A015")
# README of the data: B038 and B047 fit linear theory only without the weight on disc 2; three came days later.
DOUBTFUL = ("B038", "B047", "B007", "B031", "A027")
LEAST_NET = 20.0  # [g mm] smallest net unbalance that the issue counts


@dataclass(frozen=True)
class Records:
    """First repeats and further repeats: one row a record."""

    condition: tuple[str, ...]
    session: tuple[str, ...]
    repeat: Integers
    sealed: Integers
    rpm: Real
    unbalance: Complex  # [g mm] of disc 1 and 2, angle as lag, shape (n, 2); nan where sealed
    vectors: Complex  # [um, 0 to peak], phase as lag, shape (n, 4)

    def rows(self, condition: str) -> Integers:
        """Return the rows of one condition."""
        return np.flatnonzero(np.array(self.condition) == condition)

    def mean(self, condition: str) -> Complex:
        """Return the mean vector of the repeats of one condition [um], shape (4,)."""
        rows = self.rows(condition)
        if not len(rows):
            raise ValueError(f"the record has no condition {condition!r}; it has {len(set(self.condition))} others")
        mean: Complex = self.vectors[rows].mean(axis=0)
        return mean

    def firsts(self, *, sealed: bool) -> list[int]:
        """Return the rows of the first repeats, labelled or sealed."""
        return [int(row) for row in np.flatnonzero((self.repeat == 1) & (self.sealed == sealed))]


def read(path: Path) -> Records:
    """Return the records of a file in the form of records_1005rpm.csv.

    Raises:
        ValueError: if a column is missing, or a vector does not agree with its stated amplitude.
    """
    table = pd.read_csv(path)
    needed = [
        *("condition", "session", "repeat", "sealed", "rpm", "U1_gmm", "U1_deg", "U2_gmm", "U2_deg"),
        *(f"{probe}_{part}_mil" for probe in PROBES for part in ("re", "im", "amp")),
    ]
    if missing := [name for name in needed if name not in table.columns]:
        raise ValueError(f"{path}: expected the columns of records_1005rpm.csv, not found: {', '.join(missing)}")
    vectors = np.stack([table[f"{p}_re_mil"] + 1j * table[f"{p}_im_mil"] for p in PROBES], axis=1)
    stated = np.stack([table[f"{p}_amp_mil"] for p in PROBES], axis=1)
    if len(bad := np.flatnonzero((np.abs(np.abs(vectors) - stated) > 1e-3 * stated + 2e-5).any(axis=1))):
        raise ValueError(f"{path}, row {bad[0] + 2}: |re + j im| differs from the amplitude that the row states")
    loads = []
    for disc in ("U1", "U2"):
        size, angle = table[f"{disc}_gmm"].to_numpy(float), table[f"{disc}_deg"].fillna(0.0).to_numpy(float)
        loads.append(np.asarray(size * np.exp(1j * np.deg2rad(angle)), complex))
    return Records(
        tuple(table.condition),
        tuple(table.session),
        table.repeat.to_numpy(),
        table.sealed.to_numpy(),
        table.rpm.to_numpy(float),
        np.asarray(np.stack(loads, axis=1), complex),
        np.asarray(vectors * MICROMETRES_IN_A_MIL, complex),
    )


def told(command: Callable[[], int]) -> int:
    """Run a command; return 2 and print the reason where a file or its content is not as expected."""
    try:
        return command()
    except (OSError, ValueError) as error:
        print(f"refused: {error}", file=sys.stderr)
        return 2


def sha256(path: Path) -> str:
    """Return the hash of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
