# SPDX-License-Identifier: Apache-2.0
"""Verdict between cases: quantities that cost bits and joints, their spread over seeds, and what the runs can show."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drill_twin.api.compare import NOTHING, Case, quantities
from drill_twin.api.result import Result
from drill_twin.api.simulation import Simulation
from drill_twin.core.table import Column, Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.scene import Scene
from drill_twin.scene.load import override
from drill_twin.studies.accuracy.errors import CONFIDENCE, chance_difference

COSTS = {
    "stick-slip index": 1.0, "lateral acceleration, rms": 1.0, "axial acceleration, rms": 1.0,
    "largest bending stress": 1.0, "fatigue damage": 1.0, "largest force of the wall at a mark": 1.0,
    "margin to sinusoidal buckling": -1.0, "yield margin": -1.0, "make-up margin": -1.0,
    "margin to the nearest critical speed of the assembly": -1.0, "specific energy": 1.0, "rate of penetration": -1.0,
}  # fmt: skip
"""Quantities that cost bits and joints, the costliest first: 1 where more is worse, -1 where less is. A name is the end
of the name of a compared quantity."""
NUDGE = 0.01
"""Standard deviation of the speed of another seed, as a share: no rig holds its speed better, and where the string lies
on the wall friction forgets a push."""
PUSH = 1e-4
"""Standard deviation of the lateral velocity at mid-span that sets a run of another seed apart [m/s]."""
NONE = "no difference that the runs can show"
CHANCE = "?"
"""In place of the better case: the means differ by more than the tolerance, and chance explains it."""


class ComparedCost(NamedTuple):
    """A cost in the runs of each case, in SI."""

    name: str
    unit: str
    values: tuple[tuple[float, ...], ...]
    """By case, one a seed."""
    better: tuple[str, ...]
    """For each case but the first: `A` (the first), its own letter, `CHANCE`, or empty within the tolerance."""


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
    """Costs of cases, ranked; a cost that no run has is left out.

    A difference is shown where the means are further apart than the tolerance, a share of the larger one, and than
    chance explains at 95 % for all costs together (Welch 1947, Bonferroni); a single run a case shows none.

    Args:
        runs: Cases of each seed, in one order.
        tolerance: Share from which means differ.
    """
    tables = [{row.name: row for row in quantities(cases)} for cases in runs]
    found = []
    for cost, sign in COSTS.items():
        for name in [name for name in tables[0] if name.endswith(cost)][:1]:
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
                found.append((cost, tables[0][name].unit, values, sign))
    return [
        ComparedCost(cost, unit, values, tuple(
            _better(values[0], other, sign, tolerance, chr(ord("A") + k), len(found))
            for k, other in enumerate(values[1:], 1)
        ))
        for cost, unit, values, sign in found
    ]  # fmt: skip


def _better(
    one: Sequence[float], other: Sequence[float], sign: float, tolerance: float, letter: str, count: int
) -> str:
    if min(len(one), len(other)) < 2:
        return ""
    first, second = float(np.mean(one)), float(np.mean(other))
    if abs(second - first) <= tolerance * max(abs(first), abs(second)):
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
    title = f"what costs bits and joints: mean +- standard deviation of {count} runs; ?: it may be chance"
    return Table(("cost", *letters, "better"), rows, title=title, right=range(1, 1 + len(letters)))


def _mean_text(size: float, row: Sequence[float]) -> str:
    moved = len(row) > 1 and np.ptp(row) > NOTHING * abs(row[0])
    spread = f" +- {size * np.std(row, ddof=1):.2g}" if moved else ""
    return f"{size * np.mean(row):.4g}{spread}" if row else "none"


def verdicts(found: Sequence[ComparedCost], units: UnitSystem) -> list[str]:
    """Sentence on each case but the first."""
    if any(len(row) < 2 for cost in found for row in cost.values):
        return ["no verdict: one run of a case shows no spread; --seeds 3 repeats the cases that are scenes"]
    return [_verdict(found, k, units) for k in range(len(found[0].better))] if found else [NONE]


def _verdict(found: Sequence[ComparedCost], case: int, units: UnitSystem) -> str:
    letter = chr(ord("B") + case)
    wins = {who: [cost for cost in found if cost.better[case] == who] for who in ("A", letter)}
    told = {who: ", ".join(_told(cost, case, units) for cost in costs) for who, costs in wins.items()}
    if all(wins.values()):
        return f"neither is better in all: A in {told['A']}; {letter} in {told[letter]}"
    for who, costs in wins.items():
        if costs:
            return f"{who} is better than {letter if who == 'A' else 'A'}: {told[who]}"
    unsure = [cost for cost in found if cost.better[case] == CHANCE]
    runs = min((len(row) for cost in unsure for row in (cost.values[0], cost.values[case + 1])), default=0)
    names = ", ".join(cost.name for cost in unsure)
    more = f"; {names}: the means differ, which {runs} runs do not tell from chance (more --seeds)" if unsure else ""
    return f"A and {letter}: {NONE}{more}"


def _told(cost: ComparedCost, case: int, units: UnitSystem) -> str:
    size, unit = units.in_unit(cost.unit)
    means = [size * float(np.mean(row)) for row in (cost.values[0], cost.values[case + 1])]
    lower, higher = (means[0], means[1]) if cost.better[case] == "A" else (means[1], means[0])
    return f"{cost.name} {lower:.3g} against {higher:.3g}{'' if unit == '-' else f' {unit}'}"
