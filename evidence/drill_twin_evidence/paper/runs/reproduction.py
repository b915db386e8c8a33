# SPDX-License-Identifier: Apache-2.0
"""The complete reproduction: all runs, tables, variants, similarity and the full-size assembly."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict, dataclass, field
from typing import Any

from drill_twin import __version__
from drill_twin.core.errors import SceneError
from drill_twin.scene import Scene, load_scene
from drill_twin.studies.pool import cores, run_jobs
from drill_twin_evidence.paper.runs import full_size
from drill_twin_evidence.paper.runs.cases import MATRIX, Case, scene_of
from drill_twin_evidence.paper.runs.full_size import Disorder, FullSizeRow
from drill_twin_evidence.paper.runs.published import published
from drill_twin_evidence.paper.runs.run import Measured, Run, measure, run, runs_of
from drill_twin_evidence.paper.runs.similarity import Scale, similarity
from drill_twin_evidence.paper.runs.table import Row, Trend, rows, trends
from drill_twin_evidence.paper.runs.variants import CASES as VARIANT_CASES
from drill_twin_evidence.paper.runs.variants import VARIANTS, Variant

Key = tuple[str, Case]
MATRIX_RUN, FULL_SIZE_RUN = "bench", "full size"


def _ignore(what: str, done: int, of: int) -> None:
    """Progress callback that does nothing."""
    del what, done, of


@dataclass(frozen=True, eq=False)
class VariantResult:
    """Table of one variant of the bench."""

    variant: Variant
    rows: list[Row]
    """Rows of the table that its runs cover."""


@dataclass(frozen=True, eq=False)
class Reproduction:
    """Results of `drill-twin study paper`."""

    scene: Scene
    """The bench."""
    runs: dict[Case, Run]
    """Runs of the bench."""
    measured: dict[Case, Measured]
    rows: list[Row]
    trends: list[Trend]
    variants: list[VariantResult] = field(default_factory=list)
    full_size_runs: dict[Case, Run] = field(default_factory=dict)
    full_size: list[FullSizeRow] = field(default_factory=list)
    disorder: list[Disorder] = field(default_factory=list)

    @property
    def scales(self) -> list[Scale]:
        """Similarity of rod and field."""
        return similarity(self.scene)

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return {
            "version": __version__,
            "scene": self.scene.name,
            "numbers": [row.to_dict() for row in self.rows],
            "trends": [trend.to_dict() for trend in self.trends],
            "runs": [{**case._asdict(), **asdict(value)} for case, value in sorted(self.measured.items())],
            "variants": [
                {"name": v.variant.name, "changes": v.variant.changes, "numbers": [row.to_dict() for row in v.rows]}
                for v in self.variants
            ],
            "similarity": [asdict(scale) for scale in self.scales],
            "full_size": [row.to_dict() for row in self.full_size],
            "disorder": [asdict(value) for value in self.disorder],
        }


def reproduce(
    scene: Scene,
    *,
    processes: int | None = None,
    variants: bool = True,
    full_size_too: bool = True,
    progress: Callable[[str, int, int], None] = _ignore,
) -> Reproduction:
    """Make all runs and tables.

    Args:
        scene: The bench.
        processes: Runs at once; as many as there are cores unless given.
        variants: Run the variants of the bench.
        full_size_too: Run the full-size assembly.
        progress: Called with the run that ended, the number of runs done, and their total.

    Raises:
        RunError: The first frame of a run could not be computed.
    """
    wanted: dict[Key, Scene] = {(MATRIX_RUN, case): scene_of(scene, case) for case in MATRIX}
    if variants:
        for variant in VARIANTS[1:]:
            wanted |= {(variant.name, case): scene_of(scene, case, variant.changes) for case in VARIANT_CASES}
    full = full_size.scenes() if full_size_too else {}
    wanted = {(FULL_SIZE_RUN, case): described for case, described in full.items()} | dict(
        sorted(wanted.items(), key=lambda item: -item[0][1].weight_on_bit)
    )
    processes, runs = processes or cores(), dict[Key, Run]()
    with closing(runs_of(run, wanted, processes)) as ended:
        for key, runs[key] in ended:
            progress(f"{key[0]}, {_label(key[1])}", len(runs), len(wanted))
    bench = {case: runs[MATRIX_RUN, case] for case in MATRIX}
    measured = {case: measure(found) for case, found in bench.items()}
    big = {case: runs[FULL_SIZE_RUN, case] for case in full}
    return Reproduction(
        scene, bench, measured, rows(measured), trends(measured),
        [_variant(variant, runs, measured) for variant in VARIANTS] if variants else [],
        big, full_size.rows(big) if big else [], _disorder(full, big, processes) if big else [],
    )  # fmt: skip


def _variant(variant: Variant, runs: dict[Key, Run], measured: dict[Case, Measured]) -> VariantResult:
    if not variant.changes:
        known = {case: measured[case] for case in VARIANT_CASES}
    else:
        known = {case: measure(runs[variant.name, case]) for case in VARIANT_CASES}
    return VariantResult(variant, [row for row in rows(known) if row.number.case in VARIANT_CASES])


def _disorder(scenes: dict[Case, Scene], runs: dict[Case, Run], processes: int) -> list[Disorder]:
    jobs = {case: (case, scenes[case], runs[case]) for case in full_size.SPEEDS}
    return list(run_jobs(full_size.disorder, jobs, processes).values())


def _label(case: Case) -> str:
    if case.weight_on_bit >= 1e4:
        return f"{case.weight_on_bit * 1e-3:g} kN, {case.speed * 60.0:g} r/min"
    return str(case)


def bench(name: str = "pa6_calibrated") -> Scene:
    """The scene of the bench: the installed one, or another with the paper's marks.

    Raises:
        SceneError: There is no such scene, or it lacks a mark whose displacement is published.
    """
    scene = load_scene(name)
    names = [mark.name for mark in scene.string.marks]
    missing = sorted({number.mark for number in published().bench if number.mark and number.mark not in names})
    if missing:
        raise SceneError(
            f"{scene.name}: expected the paper's marks {', '.join(missing)} in string.marks, "
            f"found {', '.join(names) or 'none'}; begin the scene with `base: pa6_calibrated`"
        )
    return scene
