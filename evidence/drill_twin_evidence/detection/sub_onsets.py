# SPDX-License-Identifier: Apache-2.0
"""Share of onsets from one sub whose true time lies within the stated uncertainty: `make sub-onsets`.

Each number draws a scene, whose string's full state gives the true onset at one of its marks, and a prescribed motion.
A line of JSON for each is kept; a campaign that was broken off goes on from there.
"""

import sys
from pathlib import Path

import numpy as np
from scipy import stats
from typing_extensions import TypedDict

from drill_twin.core.files.json_files import JsonLines
from drill_twin.whirl import Summary
from drill_twin.whirl.downhole import SubAnalyzer
from drill_twin.whirl.downhole.motion import SLOWEST
from drill_twin_evidence.detection.cases import HEIGHTS, simulated
from drill_twin_evidence.detection.ground_truth import mark_onsets
from drill_twin_evidence.detection.sub_readings import analyser_of
from drill_twin_evidence.detection.sub_signals import drawn_signal

FIRST = 6000
"""First number that nothing was chosen on."""


class Row(TypedDict):
    """Onset from one sub."""

    kind: str
    number: int
    true: float | None
    found: float | None
    uncertainty: float | None
    """Times [s]."""
    dated: bool
    slow: bool
    """True for a motion slower than the sub can see."""


def scene(number: int) -> Row:
    """Onset in a random scene, at one of its marks."""
    mark, run = number % len(HEIGHTS), simulated(number, subs=True)
    return _row("scene", number, mark_onsets(run)[mark], analyser_of(run, number, mark=mark).summary(), 1.0)


def motion(number: int) -> Row:
    """Onset in a prescribed motion."""
    drawn = drawn_signal(number)
    analyzer = SubAnalyzer(drawn.mark, drawn.radius, drawn.noise)
    for stamp, values in zip(drawn.stamp.tolist(), drawn.readings, strict=True):
        analyzer.push(stamp, values)
    return _row("motion", number, drawn.onset, analyzer.summary(), drawn.ratio)


def _row(kind: str, number: int, true: float | None, found: Summary, ratio: float) -> Row:
    onset = found.onset
    known = (None, None, False) if onset is None else (onset.time_s, onset.uncertainty_s, onset.dated)
    return Row(kind=kind, number=number, true=true, found=known[0], uncertainty=known[1], dated=known[2],
               slow=abs(ratio) < SLOWEST)  # fmt: skip


def shares(rows: list[Row]) -> list[str]:
    """Sentences on the rows of each kind."""
    lines = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == kind]
        missed = [row for row in own if row["true"] is not None and row["found"] is None]
        false = sum(row["true"] is None and row["found"] is not None for row in own)
        given = [row for row in own if row["true"] is not None and row["uncertainty"] is not None]
        lines.append(
            f"{len(own)} {kind}s, {sum(row['true'] is not None for row in own)} with whirl: {len(missed)} missed, "
            f"{sum(row['slow'] for row in missed)} of these slower than the corner; {false} false"
        )
        for name, chosen in (("with an uncertainty", given), ("dated", [row for row in given if row["dated"]])):
            inside = [abs(row["found"] - row["true"]) <= row["uncertainty"] for row in chosen]  # type: ignore[operator]
            if inside:
                held = stats.binomtest(sum(inside), len(inside))
                low, high = held.proportion_ci(0.95)
                size = np.median([row["uncertainty"] for row in chosen])
                lines.append(
                    f"{kind}s, onsets {name}: {held.statistic:.1%} of {len(inside)} hold the true one; 95 % interval "
                    f"of the share {low:.1%} to {high:.1%}; median uncertainty {size:.2f} s"
                )
    return lines


def main(count: int, journal: Path, first: int = FIRST) -> None:
    """Compute the rows that the journal lacks, and print the shares."""
    file = JsonLines(journal, Row, "sub onsets", {"first": first})
    done = {(row["kind"], row["number"]) for row in file.results}
    for number in range(first, first + count):
        for draw in (scene, motion):
            if (draw.__name__, number) not in done:
                file.add(draw(number))
    print("\n".join(shares(file.results)))


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
