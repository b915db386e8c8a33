# SPDX-License-Identifier: Apache-2.0
"""Assumptions under which published numbers are compared: all, all but one, none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.paper.search.readings import BASE, NEAR, NUMBERS, READINGS, Results, misfits, of_kind
from drill_twin_evidence.paper.search.space import (
    BIT,
    CHOICES,
    HOLE,
    INCLINATION,
    LAW,
    LOAD_AT,
    LOAD_SHAPE,
    ROTATION_SHAPE,
    Trial,
)  # fmt: skip


class Assumptions(NamedTuple):
    """Assumptions that may differ from the bench as calibrated and from the readings of `drill-twin paper`."""

    name: str
    free: frozenset[int]
    """Choices that may differ."""
    any_reading: bool
    """True: each kind of number is read in the way that suits a set best, the same for all numbers of the kind."""

    def hold(self, one: Trial) -> bool:
        """True if a set keeps to them."""
        return all(k in self.free or option == 0 for k, option in enumerate(one.choices))

    def applied(self, one: Trial) -> Trial:
        """The set with the choices that must not differ set back."""
        return one._replace(choices=tuple(option if k in self.free else 0 for k, option in enumerate(one.choices)))


ASSUMPTIONS = (
    Assumptions("all kept", frozenset(), any_reading=False),
    Assumptions("R may be the diameter", frozenset({HOLE}), any_reading=False),
    Assumptions("the load may be counted at the top", frozenset({LOAD_AT}), any_reading=False),
    Assumptions("the hole may be inclined", frozenset({INCLINATION}), any_reading=False),
    Assumptions("the bit may be guided, or have play and a spring", frozenset({BIT}), any_reading=False),
    Assumptions("load and rotation may rise as a STEP", frozenset({LOAD_SHAPE, ROTATION_SHAPE}), any_reading=False),
    Assumptions("friction may fall to a share", frozenset({LAW}), any_reading=False),
    Assumptions("numbers may be read in any way", frozenset(), any_reading=True),
    Assumptions("none kept", frozenset(range(len(CHOICES))), any_reading=True),
)
STRICT, LOOSE = 0, len(ASSUMPTIONS) - 1


def pair_misfits(results: Results, *, any_reading: bool) -> Array:
    """Larger misfit of each two numbers, shape (15, 15); infinite where a run was not made.

    The diagonal is the misfit of a number alone.

    Args:
        results: Readings by run.
        any_reading: Take the least over the readings, both numbers of a kind read in one way.
    """
    alone = np.full(len(NUMBERS), np.inf)
    blocks = []
    for kind, part in misfits(results).items():
        filled = np.where(np.isnan(part), np.inf, part)
        if not any_reading:
            filled = filled[:, [BASE[kind]]]
        places = np.array(of_kind(kind))
        alone[places] = filled.min(axis=1)
        blocks.append((places, np.maximum(filled[:, None], filled[None]).min(axis=2)))
    table = np.maximum(alone[:, None], alone[None])
    for places, block in blocks:
        table[np.ix_(places, places)] = block
    return np.asarray(table)


ENOUGH = 2.0
"""Misfit beyond which a number counts no more in a total."""


def total(results: Results, *, any_reading: bool) -> float:
    """Sum of the misfits, each at most `ENOUGH`, in one reading of each kind; a run not made counts nothing."""
    result = 0.0
    for kind, part in misfits(results).items():
        sums = np.minimum(np.nan_to_num(part), ENOUGH).sum(axis=0)
        result += float(sums.min() if any_reading else sums[BASE[kind]])
    return result


@dataclass(frozen=True)
class Score:
    """Numbers of a set that are within 20 %.

    Attributes:
        met: How many.
        readings: The reading of each kind of number in which that is so.
    """

    met: int
    readings: dict[str, str]


def score(results: Results, *, any_reading: bool) -> Score:
    """Most numbers within 20 % in one reading of each kind."""
    count, names = 0, {}
    for kind, part in misfits(results).items():
        near = (part <= NEAR).sum(axis=0)
        best = int(np.argmax(near)) if any_reading and near.max() > near[BASE[kind]] else BASE[kind]
        count += int(near[best])
        names[kind] = READINGS[kind][best]
    return Score(count, names)
