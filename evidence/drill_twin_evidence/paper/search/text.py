# SPDX-License-Identifier: Apache-2.0
"""Result of a search as lines and tables."""

from __future__ import annotations

from collections.abc import Iterator

from drill_twin_evidence.paper.search.assumptions import ASSUMPTIONS, LOOSE, STRICT
from drill_twin_evidence.paper.search.exclusion import Exclusion, choices_of
from drill_twin_evidence.paper.search.habits import Habit
from drill_twin_evidence.paper.search.readings import NUMBERS
from drill_twin_evidence.paper.search.search import PAIRS
from drill_twin_evidence.paper.search.space import CHOICES

UNDER = ("assumptions", "pairs excluded", "of")
ALONE = ("number", "published", "least misfit, all kept", "none kept")
OPENED = ("number", "and", "all kept", "opened alone by", "none kept")
VALUES = ("number", "published", "set 1", "off by, in 20 %", "")
HABITS = ("habit", "critical times, s", "whirl at 20, 40, 150, 300 N, Hz", "mark-3, -2, -1 at 40 N, mm")
SHORT = ("set", "reading", "20 N", "150 N", "300 N", "lines at high load")
BEST = ("set", "met of 15", "in steady whirl", "assumptions", "readings", "choices that differ")

Cells = tuple[str, ...]


def lead(found: Exclusion) -> Iterator[str]:
    """Size of the search and its result."""
    yield (
        f"{found.sets} sets: {found.grown} by growth along the ramps, {found.run} by {found.runs} runs. "
        f"Critical times by growth are off from those of the runs by {found.growth_error[0]:.1%} (median), "
        f"{found.growth_error[1]:.1%} (9th decile)."
    )
    best = max(one.score.met for one in found.finalists)
    yield (
        f"At most {best} of {len(NUMBERS)} numbers within 20 % in one set. Misfits are in units of 20 %: "
        "a pair is met at 1, with the larger of its two."
    )


def under_rows(found: Exclusion) -> Iterator[Cells]:
    """Cells under `UNDER`."""
    for k, assumptions in enumerate(ASSUMPTIONS):
        yield assumptions.name, str(len(found.excluded(k))), str(len(PAIRS))


def alone_rows(found: Exclusion) -> Iterator[Cells]:
    """Cells under `ALONE`."""
    for k, number in enumerate(NUMBERS):
        yield (
            f"{number.q} {number.name}", f"{number.value:g} {number.unit}".strip(),
            *(f"{found.least[under, k, k]:.2f}" for under in (STRICT, LOOSE)),
        )  # fmt: skip


def opened_rows(found: Exclusion) -> Iterator[Cells]:
    """Cells under `OPENED`: the pairs excluded with all assumptions kept, the worst first."""
    for i, j in sorted(found.excluded(STRICT), key=lambda pair: -found.least[LOOSE][pair]):
        opened = "; ".join(ASSUMPTIONS[k].name for k in found.opened_by((i, j)))
        yield (
            f"{NUMBERS[j].q} {NUMBERS[j].name}", f"{NUMBERS[i].q} {NUMBERS[i].name}",
            f"{found.least[STRICT, i, j]:.2f}", opened or "-", f"{found.least[LOOSE, i, j]:.2f}",
        )  # fmt: skip


def best_rows(found: Exclusion) -> Iterator[Cells]:
    """Cells under `BEST`."""
    for k, one in enumerate(found.finalists, 1):
        differing = [
            f"{name} {option}"
            for (name, option), choice in zip(choices_of(one.trial).items(), CHOICES, strict=True)
            if option != choice.options[0]
        ]
        yield (
            str(k), str(one.score.met), str(one.steady), ASSUMPTIONS[one.under].name,
            "; ".join(one.score.readings.values()), "; ".join(differing) or "-",
        )  # fmt: skip


def value_rows(found: Exclusion) -> Iterator[Cells]:
    """Cells under `VALUES`: the numbers of the best set."""
    for one in found.finalists[0].values:
        unit = f" {one.number.unit}".rstrip()
        yield (
            f"{one.number.q} {one.number.name}", f"{one.number.value:g}{unit}", f"{one.ours:.3g}{unit}",
            f"{one.misfit:.2f}", f"irregular: {one.low:.2g} to {one.high:.2g} over windows" if one.irregular else "",
        )  # fmt: skip


def short_rows(found: Exclusion) -> Iterator[Cells]:
    """Cells under `SHORT`."""
    for k, one in enumerate(found.finalists, 1):
        for reading, lines, first in one.short:
            yield str(k), reading, *(f"{line:.3g} Hz" for line in lines), "the lowest there is" if first else ""


def habit_rows(found: list[Habit]) -> Iterator[Cells]:
    """Cells under `HABITS`."""
    for one in found:
        yield (
            one.name,
            ", ".join(f"{value:.2f}" for value in one.times),
            ", ".join(f"{value:+.2f}" for value in one.whirls),
            ", ".join(f"{value:.0f}" for value in one.sizes[::-1]),
        )  # fmt: skip
