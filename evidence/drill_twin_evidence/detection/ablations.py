# SPDX-License-Identifier: Apache-2.0
"""Score of the analyzer with mechanisms of the onset switched off in turn, on seeds beside the frozen records.

`python -m drill_twin_evidence.detection.ablations [RECORDS]` prints a row for each mechanism, over so many of the
shortest records of each kind.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any
from unittest.mock import patch

from drill_twin.whirl import onset_detector
from drill_twin.whirl.onset import threshold_crossing
from drill_twin.whirl.onset.threshold_crossing import Crossing
from drill_twin.whirl.onset_detector import OnsetDetector
from drill_twin_evidence.detection.frozen import FrozenRecord, frozen_records, score_of

BASES = (7_300_000, 7_400_000)
"""First seeds of the records: not the frozen ones."""


def _nothing(*_: Any, **__: Any) -> None:
    return None


def _forget(detector: Any, mark: int, *_: Any, **__: Any) -> None:
    detector._displaced.pop(mark, None)  # noqa: SLF001  the stand-in of a method


def _false(*_: Any, **__: Any) -> bool:
    return False


def _known(self: OnsetDetector) -> list[Crossing]:
    """Check the newest bin as if the steady position of the marks were known from the first bin on."""
    self._onsets.early[:] = False
    return _CHECK(self)


_CHECK = OnsetDetector.check

MECHANISMS: dict[str, list[tuple[Any, str, Callable[..., Any]]]] = {
    "all on": [],
    "`_recheck`: a displaced mark is looked at again": [(OnsetDetector, "_recheck", _forget)],
    "`refit_orbit` and `steady_position`": [
        (threshold_crossing, "refit_orbit", _nothing),
        (threshold_crossing, "steady_position", _nothing),
        (onset_detector, "steady_position", _nothing),
    ],
    "`refit_orbit`": [(threshold_crossing, "refit_orbit", _nothing)],
    "`early`: about the axis in a mark's first six revolutions": [(OnsetDetector, "check", _known)],
    "`_swung`: no search before a swing": [(OnsetDetector, "_swung", _false)],
    "`_synchronous`: critical speeds in run-ups": [(OnsetDetector, "_synchronous", _false)],
}
"""Stand-in of a mechanism: the object, the name and what replaces it."""


def shortest(each: int) -> list[FrozenRecord]:
    """So many records of each kind and base with the fewest numbers."""
    found = []
    for base in BASES:
        for kind in "abcdefgh":
            records = [one for one in frozen_records(kind, base=base) if one.truth.scored]
            found += sorted(records, key=lambda one: one.position.size)[:each]
    return found


def main(each: int) -> None:
    """Print the table."""
    records = shortest(each)
    print("| switched off | onsets | within half a revolution | missed | false | F1 string | F1 marks |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, replaced in MECHANISMS.items():
        patches = [patch.object(where, what, by) for where, what, by in replaced]
        for one in patches:
            one.start()
        found = score_of(records)["all"].plain()
        for one in patches:
            one.stop()
        numbers = (found[key] for key in ("onsets", "half", "missed", "false"))
        scores = (f"{found[key]:.3f}" for key in ("string", "marks"))
        print(f"| {' | '.join([name, *map(str, numbers), *scores])} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
