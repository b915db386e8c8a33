# SPDX-License-Identifier: Apache-2.0
"""Runs of a scene without each of its effects, and the smallest set of effects that keeps the results."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from drill_twin.core.errors import RunError
from drill_twin.physics.effects import EFFECTS
from drill_twin.scene import load_scene
from drill_twin.scene.check import TOGETHER
from drill_twin.studies.accuracy.errors import AblationQuantity, Trial, differences, trial_of, worst
from drill_twin.studies.accuracy.motion_run import Motion, cached_run
from drill_twin.studies.pool import run_jobs

Group = tuple[str, ...]
"""Keys of effects that are left out together."""


@dataclass(frozen=True)
class Change:
    """Change of results and cost without a group of effects."""

    left_out: tuple[str, ...]
    """Keys of the effects that were left out: one effect, and the effects that require it."""
    quantities: dict[str, AblationQuantity] = field(default_factory=dict)
    """Results with and without, by name; empty if the run failed."""
    cost_share: float | None = None
    """Share of the run time that is saved [-]; negative if the run without it takes longer, None if it failed."""
    iteration_share: float | None = None
    """Share of the time of a Newton iteration that is saved [-]."""
    failure: str = ""
    """Reason why the run without it failed; empty if it did not."""

    @property
    def size(self) -> float:
        """Largest change, in tolerances; infinite without a run."""
        return float("inf") if self.failure else worst(self.quantities)

    @property
    def needed(self) -> bool:
        """True if the scene needs the group: the run fails, or a change is significant and beyond the tolerance."""
        return bool(self.failure) or any(quantity.matters for quantity in self.quantities.values())

    @property
    def unknown(self) -> bool:
        """True if it is not known to be needed, but the runs are too few to tell."""
        return not self.needed and not all(quantity.known for quantity in self.quantities.values())


@dataclass(frozen=True)
class Ablation:
    """Result of the study of one scene."""

    scene: str
    effects: tuple[str, ...]
    tolerance: float
    replicas: int
    baseline: tuple[Trial, ...]
    changes: tuple[Change, ...]
    kept: tuple[str, ...]
    """Effects that the scene needs at this tolerance, or of which too few runs do not tell."""
    reduced: Change
    """Change without all the others."""


def groups(effects: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Groups to leave out together: each effect with all that require it.

    >>> groups(("stretch", "torsion", "wall", "wall_friction"))
    [('stretch', 'torsion'), ('wall', 'wall_friction'), ('wall_friction',)]
    """
    found: list[tuple[str, ...]] = []
    for effect in effects:
        out = {effect, *(TOGETHER if effect in TOGETHER else ())}
        while more := {key for key in effects if key not in out and set(EFFECTS[key].requires) & out}:
            out |= more
        group = tuple(key for key in effects if key in out)
        if group not in found:
            found.append(group)
    return found


def ablate(
    scene: str,
    overrides: Mapping[str, str],
    folder: Path,
    *,
    tolerance: float,
    replicas: int,
    workers: int = 2,
    progress: Callable[[str], None] = lambda _: None,
) -> Ablation:
    """Run a scene with all its effects, without each effect, and with only the effects that the scene needs.

    Args:
        scene: Name or file of the scene.
        overrides: Changes to it.
        folder: Cache of runs, so that an interrupted study continues.
        tolerance: Change that counts, as a share of the value (of the clearance for the radius).
        replicas: Runs per set of effects, which differ by a small random velocity; at least 2.
        workers: Processes.
        progress: Called with the effects left out as each run ends.

    Raises:
        SceneError: The scene is invalid.
        RunError: The scene with all its effects cannot be run.
    """
    effects = tuple(load_scene(scene, overrides=dict(overrides)).effect_names)

    def run(left_out: list[Group], name: str = "") -> dict[Group, tuple[Trial, ...] | str]:
        off = {group: dict.fromkeys((f"effects.{key}" for key in group), "off") for group in left_out}
        jobs = {  # each kernel is compiled by one worker
            (group, seed): (scene, {**overrides, **off[group]}, seed, folder)
            for seed in range(replicas)
            for group in left_out
        }
        done = run_jobs(
            cached_run, jobs, workers, done=lambda key, _: progress(name + (", ".join(key[0]) or "nothing"))
        )
        return {group: _trials([done[group, seed] for seed in range(replicas)]) for group in left_out}

    results = run([(), *groups(effects)])
    if isinstance(baseline := results.pop(()), str):
        raise RunError(f"the scene with all its effects cannot be run: {baseline}")
    changes = [_change(group, baseline, trials, tolerance) for group, trials in results.items()]
    left_out = _without(effects, {change.left_out[0] for change in changes if change.needed or change.unknown})
    while True:
        reduced = _change(left_out, baseline, run([left_out], "all of ")[left_out] if left_out else baseline, tolerance)
        if not left_out or not (reduced.needed or reduced.unknown):
            break
        candidates = [change for change in changes if change.left_out[0] in left_out]  # may matter together
        left_out = _without(left_out, {max(candidates, key=lambda change: change.size).left_out[0]})
    kept = tuple(key for key in effects if key not in left_out)
    return Ablation(scene, effects, tolerance, replicas, baseline, tuple(changes), kept, reduced)


def _trials(runs: list[Motion | str]) -> tuple[Trial, ...] | str:
    """Results of the runs of one set of effects, or the message of the first that failed."""
    failures = [run for run in runs if isinstance(run, str)]
    return failures[0] if failures else tuple(trial_of(run) for run in runs if isinstance(run, Motion))


def _change(
    group: tuple[str, ...], baseline: tuple[Trial, ...], without: tuple[Trial, ...] | str, tolerance: float
) -> Change:
    if isinstance(without, str):
        return Change(group, failure=without)
    return Change(
        group, differences(baseline, without, tolerance), _saved(baseline, without, "cost"),
        _saved(baseline, without, "iteration_cost"),
    )  # fmt: skip


def _saved(before: tuple[Trial, ...], after: tuple[Trial, ...], name: str) -> float:
    """Share of a cost that is saved [-], from the fastest run of each: other load on the machine only adds time."""
    return 1.0 - float(min(getattr(trial, name) for trial in after) / min(getattr(trial, name) for trial in before))


def _without(effects: tuple[str, ...], wanted: set[str]) -> tuple[str, ...]:
    """Effects that are neither wanted nor required by a wanted effect."""
    wanted |= set(TOGETHER) if wanted & set(TOGETHER) else set()
    while more := {need for key in wanted for need in EFFECTS[key].requires} - wanted:
        wanted |= more
    return tuple(key for key in effects if key not in wanted)
