# SPDX-License-Identifier: Apache-2.0
"""Worth of jumps and restarts: `python -m drill_twin_evidence.estimation.switched_off CASES FIRST TRUTHS`.

The same truths are followed as they are, without jumps, and with a wider spread of the numbers in place of restarts.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from unittest.mock import patch

import numpy as np

from drill_twin.core.arrays import Mask
from drill_twin.core.table import Table
from drill_twin_evidence.estimation.cases import CASES, JUMP, TOLERANCES
from drill_twin_evidence.estimation.hidden_truth import Followed, follow
from drill_twin_studies.estimation.doubts import Jumps
from drill_twin_studies.estimation.ensemble_filter import EnsembleFilter

_SECONDS, _MEMBERS = 55.0, 32
_SPREAD = 0.5
"""Of the prior, that numbers of the channel that jumps get instead of a restart."""


def _none(jumps: Jumps, *_: object) -> Mask:
    return np.zeros(len(jumps._keys), dtype=bool)  # noqa: SLF001  a part is switched off from outside, here and below


def _widen(of: EnsembleFilter, start: float, told: Mask) -> None:
    """Take any number of the channel for the one that has jumped, and widen its spread."""
    normal = of.members.normal
    mean, deviation = normal.mean(axis=0), normal.std(axis=0)
    of.members.set_numbers(mean + (normal - mean) * np.where(told, np.maximum(_SPREAD / deviation, 1.0), 1.0))
    of._jumps.explain(start, told)  # noqa: SLF001
    of._errors.forget()  # noqa: SLF001
    of._doubts.forget()  # noqa: SLF001


WAYS: Mapping[str, Callable[[], object]] = {
    "as it is": lambda: patch.object(Jumps, "take", Jumps.take),
    "no jumps": lambda: patch.object(Jumps, "take", _none),
    "wider spread": lambda: patch.object(EnsembleFilter, "_start_again", _widen),
}
"""Ways by name."""


def row(case: str, way: str, number: int, found: Followed) -> tuple[object, ...]:
    """Row of the table."""
    changed = [key for key, value in found.hidden.items() if value != found.before[key]]
    after = max((found.found_after(key, TOLERANCES.get(key, 0.05)) for key in changed), default=0.0)
    told = next((f"{time - JUMP:.0f} s" for time in found.alarms if time > JUMP), "no")
    others = [found.dragged(key) for key in found.hidden if key not in changed]
    dragged = f"{max(one[0] for one in others):.1%}" if others else ""
    worst = max(abs(error) for error in found.errors.values())
    return (case, number, way, told, f"{after:.0f} s", dragged, f"{worst:.1%}",
            f"{sum(found.held.values())} of {len(found.held)}", f"{found.coverage('bit_speed'):.0%}")  # fmt: skip


def main(cases: str, first: int, truths: int) -> None:
    """Print a row for each case, truth and way."""
    rows = []
    for case in cases.split(","):
        for number in range(first, first + truths):
            for way, change in WAYS.items():
                with change():  # type: ignore[attr-defined]
                    rows.append(row(case, way, number, follow(CASES[case], number, _SECONDS, _MEMBERS)))
    heads = ("jump", "truth", "way", "told", "followed", "dragged", "worst error", "numbers held", "bit speed held")
    print(Table(heads, rows).markdown())


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
