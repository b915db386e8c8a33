# SPDX-License-Identifier: Apache-2.0
"""Messages of a bag that cannot be used: counted by topic, and found by their stamps."""

from collections.abc import Sequence
from statistics import median_low

from drill_twin.core.errors import printable
from drill_twin.io.messages.stamps import NANOSECONDS

_FAR = NANOSECONDS  # least time [ns] between a stray stamp and the stamps around it
_FAR_AT_END = 60 * NANOSECONDS  # for the last stamp, which no stamp follows
_WINDOW = 5  # messages that follow
_LONGEST_REASON = 300


class SkippedMessages:
    """Number of skipped messages by topic, with the simulated time and the reason of the first."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._first: dict[str, tuple[float, str]] = {}

    def __len__(self) -> int:
        return sum(self._counts.values())

    def __contains__(self, topic: str) -> bool:
        return topic in self._counts

    def add(self, topic: str, time: float, reason: object, count: int = 1) -> None:
        """Count messages at a simulated time [s]."""
        self._counts[topic] = self._counts.get(topic, 0) + count
        if topic not in self._first:
            text = printable(str(reason), keep="")
            self._first[topic] = (time, text if len(text) <= _LONGEST_REASON else text[:_LONGEST_REASON] + "...")

    def sentences(self) -> list[str]:
        """One sentence a topic."""
        sentences = []
        for topic, count in self._counts.items():
            time, reason = self._first[topic]
            which = "messages on {} could not be used, the first at" if count > 1 else "message on {} not usable, at"
            sentences.append(f"{count} {which.format(topic)} {time:.3f} s: {reason}")
        return sentences


def stray_stamps(stamps: Sequence[int]) -> set[int]:
    """Places of the stamps [ns] of one topic that are far from the stamps before and after them.

    All that follows a stamp from the future would look late. A stream that starts again from an earlier time has none.
    """
    stray: set[int] = set()
    before: int | None = None
    for place, stamp in enumerate(stamps):
        if before is None or abs(stamp - before) > _FAR:
            level = median_low(stamps[place + 1 : place + 1 + _WINDOW] or [stamp])
            too_late = stamp - level > _FAR and (before is None or level > before)
            too_early = before is not None and stamp < before < level
            at_end = before is not None and place == len(stamps) - 1 and abs(stamp - before) > _FAR_AT_END
            if too_late or too_early or at_end:
                stray.add(place)
                continue
        before = stamp
    return stray
