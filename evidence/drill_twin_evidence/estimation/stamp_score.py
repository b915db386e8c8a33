# SPDX-License-Identifier: Apache-2.0
"""Score of the estimator over stamps and rates: `python -m drill_twin_evidence.estimation.stamp_score TRUTHS FIRST`.

The scene is that of the case `torsion`, in stick-slip with a cycle of 5 s; the bands of some seconds of each truth are
counted together.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from drill_twin.core.table import Table
from drill_twin_evidence.estimation.cases import CASES
from drill_twin_evidence.estimation.hidden_truth import TruthRow, follow
from drill_twin_evidence.estimation.stamps import USUAL, Stamps

_EXACT = Stamps(offset=0.0, drift=0.0, jitter=0.0, lost=0.0)
WAYS: Mapping[str, Stamps] = {
    "exact": _EXACT,
    "1 ms late": replace(_EXACT, offset=1e-3),
    "errors up to 2 ms": replace(_EXACT, jitter=2e-3),
    "clock 100 ppm fast": replace(_EXACT, drift=1e-4),
    "30 ms late, 3 % lost": replace(_EXACT, offset=0.03, lost=0.03),
    "errors up to 30 ms": replace(_EXACT, jitter=0.03),
    **{f"drawn, {rate:g} Hz": replace(USUAL, rate=rate) for rate in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 100.0)},
    "drawn, instants": replace(USUAL, instant=True),
}
"""Stamps by name; 10 Hz where no rate is named."""
_SECONDS, _MEMBERS = 30.0, 16


def rows_of(stamps: Stamps, truths: int, first: int) -> list[TruthRow]:
    """Truths, followed; instants need frames that are short against the time from sample to sample."""
    case = CASES["torsion"]
    if stamps.instant:
        case = replace(case, overrides=dict(case.overrides) | {"numerics.frame_rate": 50.0})
    numbers = range(first, first + truths)
    return [follow(case, k, _SECONDS, _MEMBERS, stamps=stamps).row("torsion", _MEMBERS, k) for k in numbers]


def cells(name: str, rows: Sequence[TruthRow]) -> tuple[str, ...]:
    """Line of the table: shares of windows in which bands hold the truth, and are shown; bands of numbers; alarms."""
    held = [bool(held) for row in rows for held in row["held"].values()]
    return (
        name,
        *(
            f"{np.mean([row['coverage'][sensor] for row in rows]):.0%}"
            if any(row["shown"][sensor] for row in rows)
            else "withheld"
            for sensor in ("bit_speed", "bit_torque", "weight_on_bit")
        ),
        f"{np.mean([row['shown']['bit_speed'] for row in rows]):.0%}",
        f"{sum(held)} of {len(held)}",
        f"{sum(len(row['alarms']) for row in rows)}",
    )


def main(truths: int, first: int) -> None:
    """Follow the truths in each way, and print the table."""
    heads = ("stamps", "bit speed held", "bit torque", "weight on bit", "bit speed shown", "numbers held", "alarms")
    lines = []
    for name, stamps in WAYS.items():
        lines.append(cells(name, rows_of(stamps, truths, first)))
        print(*lines[-1], sep=", ", file=sys.stderr, flush=True)
    print(Table(heads, lines).markdown())


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
