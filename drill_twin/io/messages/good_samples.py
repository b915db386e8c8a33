# SPDX-License-Identifier: Apache-2.0
"""Age of the last good sample of each input of a node, and the count of the bad ones since."""

import math
import time
from collections import Counter, deque
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from statistics import median

from drill_twin.io.messages.diagnostics import Level

STALE, GONE = 1.0, 3.0
"""Age above which a value is stale, and gone [s]; of an input that comes slowly, times its usual interval."""
FIRST = 5.0
"""Age above which the first good sample is stale [s]: how often the input comes is not known yet. An
input of which nothing has come is waited for as long without a fault, as nodes find each other; not measured."""
_INTERVALS = 9
_KINDS = {
    "not_finite": "had no finite number",
    "unreadable": "could not be read",
    "out_of_order": "were late or repeated",
}
"""Kinds of bad samples, and in words."""


@dataclass
class _Input:
    begun: float
    last: float
    good: float | None = None
    longest: float = 0.0
    intervals: deque[float] = field(default_factory=lambda: deque(maxlen=_INTERVALS))
    bad: Counter[str] = field(default_factory=Counter)
    since: Counter[str] = field(default_factory=Counter)  # bad samples since the last good sample

    @property
    def stale_after(self) -> float:
        if self.good is None:
            return STALE
        return max(STALE, GONE * max(self.longest, median(self.intervals))) if self.intervals else FIRST


class GoodSamples:
    """Good and bad samples by input: a topic, or a channel of one.

    An expected input of which nothing has come is waited for, and a WARN after `FIRST`. An input that falls silent is
    STALE. An input that goes on to come without a good sample is a WARN, and an ERROR once this lasts three times as
    long.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, *, on_change: Collection[str] = ()) -> None:
        """Start without samples.

        Args:
            clock: Monotonic time [s].
            on_change: Inputs that come on change only, whose silence is no fault.
        """
        self._clock, self._on_change = clock, frozenset(on_change)
        self.longest: dict[str, float] = {}
        """Longest intervals [s] of inputs that come on change and otherwise at this interval."""
        self._inputs: dict[str, _Input] = {}
        self._expected: dict[tuple[str, ...], float] = {}  # since when
        self._judged_from = -math.inf

    def expect(self, *names: str) -> None:
        """Begin to wait for a sample of one of some inputs."""
        self._expected |= {names: self._clock()} if names else {}

    def rest(self, seconds: float = 0.0) -> None:
        """Judge no silence for a time [s], in which none is a fault, and from then on as if all had come just then."""
        self._judged_from = self._clock() + seconds

    @property
    def rests(self) -> bool:
        """True while silence is not judged."""
        return self._clock() < self._judged_from

    def take(self, name: str, *, finite: bool = True, in_order: bool = True) -> None:
        """Note a sample that could be read.

        Args:
            name: Input.
            finite: Whether it has a finite number that is used.
            in_order: Whether the sample's stamp is later than the stamps before.
        """
        if not (finite and in_order):
            self._bad(name, "out_of_order" if finite else "not_finite")
            return
        found = self._heard(name)
        if found.good is not None:
            found.intervals.append(found.last - found.good)
        found.good = found.last
        found.since.clear()

    def unreadable(self, name: str) -> None:
        """Note a sample that could not be read."""
        self._bad(name, "unreadable")

    def age(self, name: str) -> float:
        """Time since the last good sample of an input [s]; infinite before the first."""
        found = self._inputs.get(name)
        return math.inf if found is None or found.good is None else self._clock() - found.good

    def patience(self, name: str) -> float:
        """Age above which an input of which something has come is stale [s]."""
        return self._inputs[name].stale_after

    def values(self) -> dict[str, str]:
        """Values for the diagnostics: age [s] by input, infinite before the first good one, and bad samples in all."""
        return {f"good_sample_age {name}": f"{self.age(name):.3f}" for name in self._inputs} | {
            f"{kind} {name}": str(count) for name, found in self._inputs.items() for kind, count in found.bad.items()
        }

    def verdict(self) -> tuple[Level, str]:
        """Level, and a sentence on the input without a good sample for longest; OK and empty where there is none."""
        now, worst, level, text = self._clock(), 0.0, Level.OK, ""
        for name, found in self._inputs.items():
            age = now - max(found.begun if found.good is None else found.good, self._judged_from)
            rests = name in self._on_change and not found.since
            if rests or age <= found.stale_after or age <= worst:
                continue
            last = max(found.last, self._judged_from)
            silent = now - last > found.stale_after and name not in self._on_change
            level = Level.STALE if silent else Level.WARN if age <= GONE * found.stale_after else Level.ERROR
            bad = ", ".join(f"{count} samples {_KINDS[kind]}" for kind, count in found.since.items())
            worst, text = age, f"no good sample of {name} for {age:.1f} s{f' ({bad})' if bad else ''}"
        return (level, text) if text else self._waits(now)

    def _waits(self, now: float) -> tuple[Level, str]:
        """Level, and a sentence on the first expected inputs of which nothing has come."""
        for names, since in self._expected.items():
            if self._inputs.keys().isdisjoint(names):
                waited = now - max(since, self._judged_from)
                told = " or ".join(names) if len(names) < 3 else f"any of {len(names)} topics"
                if waited <= FIRST:
                    return Level.OK, f"waiting for {told}"
                return Level.WARN, f"no message on {told} for {waited:.0f} s: {self.advice(names)}"
        return Level.OK, ""

    def advice(self, names: tuple[str, ...]) -> str:
        """Advice on inputs of which nothing has come."""
        return f"expected a publisher of {' or '.join(names)}"

    def _heard(self, name: str) -> _Input:
        now = self._clock()
        found = self._inputs.setdefault(name, _Input(now, now, longest=self.longest.get(name, 0.0)))
        found.last = now
        return found

    def _bad(self, name: str, kind: str) -> None:
        found = self._heard(name)
        found.bad[kind] += 1
        found.since[kind] += 1
