# SPDX-License-Identifier: Apache-2.0
"""Verdict between cases: quantities that cost bits and joints, their spread over seeds, and what the runs can show."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drill_twin.api.compared_quantities import NOTHING, RELEVANCE, Case, graded, quantities
from drill_twin.api.result import Result
from drill_twin.api.simulation import Simulation
from drill_twin.core.severity import WORDS, Grade, grade
from drill_twin.core.table import Column, Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.scene import Scene
from drill_twin.scene.load import override
from drill_twin.studies.accuracy.errors import CONFIDENCE, chance_difference

NUDGE = 0.01
"""Standard deviation of the speed of another seed, as a share: no rig holds its speed better, and where the string lies
on the wall friction forgets a push."""
PUSH = 1e-4
"""Standard deviation of the lateral velocity at mid-span that sets a run of another seed apart [m/s]."""
NONE = "none that matters"
CHANCE = "?"
"""In place of the better case: the means differ by what matters, and chance explains it."""


class ComparedCost(NamedTuple):
    """A cost in the runs of each case, in SI."""

    name: str
    unit: str
    values: tuple[tuple[float, ...], ...]
    """By case, one a seed."""
    better: tuple[str, ...]
    """For each case but the first: `A` (the first), its own letter, `CHANCE`, or empty where no difference matters."""
    matters: float = 0.0
    """Difference of the means below which nothing matters."""
    grades: tuple[int, ...] = ()
    """Grade of severity of the mean of each case; empty for a quantity without grades."""

    def rank(self, case: int) -> tuple[float, float]:
        """Key by which the differences of two cases are ranked: the higher grade of both, then how much it matters."""
        one, other = (float(np.mean(self.values[k])) for k in (0, case + 1))
        scale = self.matters or max(abs(one), abs(other))
        grade = max(self.grades[0], self.grades[case + 1]) if self.grades else -1
        return grade, abs(other - one) / scale


def again(
    first: Sequence[Case], what: Sequence[Scene | Result], seed: int, progress: Callable[[str], None] | None = None
) -> list[Case]:
    """Run the cases with another seed, which draws a push and a change of the speed; a bag is not run again.

    Args:
        first: Cases in their first runs, whose balance holds for all seeds.
        what: Scene or bag of each.
        seed: Number of the seed, from 1.
        progress: Takes the name of a case before its run.

    Raises:
        RunError: A run stops early.
    """
    found = []
    for case, source in zip(first, what, strict=True):
        if not isinstance(source, Scene):
            found.append(case)
            continue
        if progress is not None:
            progress(case.name)
        kick = source.effects.lateral_kick
        number = source.numerics.seed + seed
        push, nudge = (PUSH, NUDGE) * np.random.default_rng(number).standard_normal(2)
        changes = {"effects.lateral_kick.velocity": push + (kick.velocity if kick else 0.0)}
        if source.rig.rotation.value:  # a recorded speed stays
            changes["rig.rotation.value"] = (1.0 + nudge) * source.rig.rotation.value
        own = override(source, {key: float(value) for key, value in changes.items()} | {"numerics.seed": number})
        found.append(replace(case, result=Simulation(own).run()))
    return found


def costs(runs: Sequence[Sequence[Case]], tolerance: float) -> list[ComparedCost]:
    """Costs of cases in the order of `RELEVANCE`; a cost that no run has is left out.

    A difference is shown where the means are further apart than matters, than the tolerance, a share of the larger one,
    and than chance explains at 95 % for all costs together (Welch 1947, Bonferroni); a single run a case shows none.

    Args:
        runs: Cases of each seed, in one order.
        tolerance: Share from which means differ.
    """
    tables = [{row.name: row for row in quantities(cases)} for cases in runs]
    found, bounds = [], runs[0][0].bounds
    for cost, what in RELEVANCE.items():
        for name in [name for name in tables[0] if name.endswith(cost) and what.sign][:1]:
            values = tuple(
                tuple(
                    float(table[name].values[k])
                    for seed, table in enumerate(tables)
                    if name in table
                    and (seed == 0 or runs[seed][k] is not runs[0][k])  # a bag stands for all seeds
                    and math.isfinite(float(table[name].values[k]))
                )
                for k in range(len(runs[0]))
            )
            if any(values):
                least = tables[0][name].matters
                grades = tuple(
                    int(grade(what.key, float(np.mean(row)), bounds) or 0) if row else 0
                    for row in values
                    if graded(what.key, runs[0][0]) and WORDS[what.key] == cost
                )
                better = tuple(chr(ord("A") + k) for k in range(1, len(values)))
                found.append(ComparedCost(cost, tables[0][name].unit, values, better, least, grades))
    return [
        cost._replace(better=tuple(
            _better(first, other, RELEVANCE[cost.name].sign, (tolerance, cost.matters), letter, len(found))
            for letter, other in zip(cost.better, others, strict=True)
        ))
        for cost in found
        for first, *others in [[[min(one, RELEVANCE[cost.name].enough) for one in row] for row in cost.values]]
    ]  # fmt: skip


def _better(
    one: Sequence[float], other: Sequence[float], sign: float, least: tuple[float, float], letter: str, count: int
) -> str:
    """The better case; `least` holds the share and the size from which means differ."""
    if min(len(one), len(other)) < 2:
        return ""
    first, second = float(np.mean(one)), float(np.mean(other))
    if abs(second - first) <= max(least[0] * max(abs(first), abs(second)), least[1]):
        return ""
    if abs(second - first) <= chance_difference(list(one), list(other), 1.0 - (1.0 - CONFIDENCE) / count):
        return CHANCE
    return letter if sign * second < sign * first else "A"


def cost_table(found: Sequence[ComparedCost], units: UnitSystem) -> Table:
    """Mean and standard deviation of each cost, and which case is better where the runs show it."""
    letters = [chr(ord("A") + k) for k in range(len(found[0].values))] if found else ["A"]
    rows = []
    for cost in found:
        size, unit = units.in_unit(cost.unit)
        cells = [_mean_text(size, row) for row in cost.values]
        rows.append((Column(cost.name, unit.strip("-")).title, *cells, ", ".join(one or "-" for one in cost.better)))
    count = max((len(row) for cost in found for row in cost.values), default=0)
    title = (
        f"what costs bits and joints: mean +- standard deviation, {count} run{'s' * (count > 1)}; ?: it may be chance"
    )
    return Table(("cost", *letters, "better"), rows, title=title, right=range(1, 1 + len(letters)))


def _mean_text(size: float, row: Sequence[float]) -> str:
    moved = len(row) > 1 and np.ptp(row) > NOTHING * abs(row[0])
    spread = f" +- {size * np.std(row, ddof=1):.2g}" if moved else ""
    return f"{size * np.mean(row):.4g}{spread}" if row else "none"


def verdicts(found: Sequence[ComparedCost], units: UnitSystem, first: Sequence[Case] = ()) -> list[str]:
    """Sentence on each case but the first, and on the side force at the bit of each case whose balance is known."""
    said = [_verdict(found, k, units) for k in range(len(found[0].better))] if found else [NONE]
    if any(len(row) < 2 for cost in found for row in cost.values):
        said = ["no verdict: one run of a case shows no spread; --repeats 3 repeats the cases that are scenes"]
    sides = [case.loads.contacts[0].build if case.loads else math.nan for case in first]
    if any(map(math.isfinite, sides)):
        said.append(f"side force at the bit: {', '.join(_side(k, force, units) for k, force in enumerate(sides))}")
    elif first:
        said.append("side force at the bit: neither build nor drop, as no hole is inclined there, or has a balance")
    return said


def _side(case: int, force: float, units: UnitSystem) -> str:
    """Side force of a case, signed, with what it does to the angle of the hole."""
    way = (
        "not known"
        if math.isnan(force)
        else f"{units.text(force, 'force', '+.3g')} ({'build' if force > 0 else 'drop'})"
    )
    return f"{chr(ord('A') + case)} {way}"


def _verdict(found: Sequence[ComparedCost], case: int, units: UnitSystem) -> str:
    letter = chr(ord("B") + case)
    ranked = sorted((cost for cost in found if cost.better[case]), key=lambda cost: cost.rank(case), reverse=True)
    told: dict[str, list[str]] = {"A": [], letter: [], CHANCE: []}
    for cost in ranked:
        told[cost.better[case]].append(_told(cost, case, units))
    unsure, shown = ([cost for cost in ranked if (cost.better[case] == CHANCE) is way] for way in (True, False))
    runs = min((len(row) for cost in unsure for row in (cost.values[0], cost.values[case + 1])), default=0)
    chance = f"the means differ, which {runs} runs do not tell from chance (more --repeats)"
    more = f"; {', '.join(told[CHANCE])}: {chance}" if unsure else ""
    if not shown:
        return f"A and {letter}: {NONE}{more}"
    if unsure and unsure[0].rank(case)[0] > max(shown[0].rank(case)[0], Grade.NONE):
        sure = "".join(f"; {one} is better by {', '.join(told[one])}" for one in ("A", letter) if told[one])
        return f"A and {letter}: not decided, as the highest grade may be one by chance{more}{sure}"
    better = shown[0].better[case]
    other = letter if better == "A" else "A"
    first, *also = told[better]
    rest = "".join(
        f"; {word}: {', '.join(ones)}" for word, ones in (("also", also), ("against it", told[other])) if ones
    )
    return f"{better} is better than {other}, decided by {first}{rest}{more}"


def _told(cost: ComparedCost, case: int, units: UnitSystem) -> str:
    """The cost of the better case (by chance: the first case) against the other's, with their grades."""
    size, unit = units.in_unit(cost.unit)
    order = (0, case + 1) if cost.better[case] in {"A", CHANCE} else (case + 1, 0)
    mine, other = (
        f"{size * float(np.mean(cost.values[k])):.3g}{f' ({Grade(cost.grades[k]).word})' if cost.grades else ''}"
        for k in order
    )
    return f"{cost.name} {mine} against {other}{'' if unit == '-' else f' {unit}'}"
