# SPDX-License-Identifier: Apache-2.0
"""Cause of the whirl or torsion of a run: growth of its modes, and repeats of the run with one change."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

from drill_twin.api.repeats import CALM, STIFF, Repeats, Trial, rate
from drill_twin.api.result import Result
from drill_twin.api.rotordynamics import modes_under
from drill_twin.core.errors import BagError, RunError
from drill_twin.core.table import Table
from drill_twin.dynamics.rotordynamics.modes import LATERAL, Mode, ModeTable
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.report.load_text import Summary
from drill_twin.report.recording import Recording
from drill_twin.report.severity import TORSION, WHIRL
from drill_twin.report.text import lasting
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin.whirl import MotionState

SOFT = "a top drive that does not hold its speed"


@dataclass(frozen=True)
class Cause:
    """Cause of the whirl or torsion of a run; `str` gives the sentences."""

    sentences: tuple[str, ...]
    """Motion and its severity, mode, the cause of each problem, and what would cure it."""
    causes: tuple[str, ...] = ()
    """Changes that take a problem away and name its cause; empty: the cause is not known, or there is no problem."""
    trials: tuple[Trial, ...] = ()
    """All repeats."""

    def __str__(self) -> str:
        return " ".join(self.sentences)

    def shown(self) -> Iterator[Table | str]:
        """Sentences and a table of the repeats, for a terminal."""
        yield from self.sentences
        if self.trials:
            yield Table(("repeat of the run", "what it did"), [(trial.change, trial.outcome) for trial in self.trials])

    def as_data(self) -> dict[str, Any]:
        """Plain types."""
        return asdict(self) | {"trials": [trial._asdict() for trial in self.trials]}


def why(result: Result, *, progress: Callable[[str, float, float], None] | None = None) -> Cause:
    """Find why a run whirled, swung or stuck and slipped.

    The lateral modes under the set-points at the onset say whether the string leaves its balance by itself.
    Then the run is repeated under its recorded set-points, to 30 s after the onset at most, each time with one change:
    held for longer; an effect left out that can feed the motion; less of the weight, the speed, the wall friction.
    An effect is a cause only where the repeat without it has no problem any more (no whirl and no growing mode, or
    another kind and a grade of low at most) and half of the motion at most; and so at 0.98 and 1.02 of the speed, where
    the run itself has the problem there.

    >>> print(why(Simulation("pa6_bench", {"wob": 5}).run()))

    Args:
        result: A run, or the bag of one.
        progress: Takes the name of each repeat before it begins, how many are done, and how many there are at most.

    Raises:
        BagError: The bag is the record of a rig, its scene is not known, or it has no rig states.
    """
    return cause_of(result.recording, result.summary, progress=progress)


def cause_of(
    recording: Recording, summary: Summary, *, progress: Callable[[str, float, float], None] | None = None
) -> Cause:
    """As `why`, from a recording and its summary."""
    if isinstance(recording.bag, RecordBag) or not recording.scene_known:
        raise BagError(
            f"{recording.path}: expected the bag of a run with its scene, found none; give the scene with --scene"
        )
    return _Search(recording, summary, progress or (lambda *_: None)).cause()


class _Search(Repeats):
    """Repeats of a run, and what they say of its cause."""

    def cause(self) -> Cause:
        """Sentences, from the modes and all repeats."""
        self.progress("modes", 0, len(self.plans()))
        table = self.modes(self.scene, self.steady) if WHIRL in self.problems or not self.problems else None
        fastest = table.fastest(LATERAL) if table else None
        if not self.problems:
            calm = f"The run has no problem: the string does not whirl, at {self.point} at its end."
            return Cause((calm, self.mode_text(table, fastest)))
        sentences, buckled = list[str](), ""
        if WHIRL in self.problems:
            sentences += [self.what(), self.mode_text(table, fastest)]
        if table is not None and table.on_axis and fastest is not None and fastest.growth > 0.0:
            try:
                at_rest = buckling(self.scene, self.steady)
                if at_rest is not None and self.matters(at_rest):
                    buckled = f" The weight buckles the string: without rotation, too, a mode {rate(at_rest)}."
                sentences[-1] += buckled
            except RunError as error:
                sentences[-1] += f" Whether the weight buckles it is not known ({error})."
        sentences += [self.motion_text(problem) for problem in self.problems if problem != WHIRL]
        if self.reached != 1.0:
            turns = self.units.text(self.reached * self.command.rotation, "rotation")
            sentences.append(
                f"The top drive does not keep to its set-point: it turns at {turns} on average. Repeats {STIFF}, or at "
                f"a share of the speed, are of {turns}."
            )
        trials, causes = tuple(self.trials()), list[str]()
        for problem in self.problems:
            named = self.causes(problem, trials, buckled=bool(buckled))
            causes += [trial.change for trial in named if trial.change not in causes]
            sentences.append(self.named(problem, named, trials))
        less = [trial for trial in trials[1:] if not trial.of_effects]
        sentences += [told for problem in self.problems if (told := self.cures(problem, less))]
        return Cause(tuple(sentences), tuple(causes), trials)

    def what(self) -> str:
        """Whirl or swing of the run."""
        size = self.recorded.text(WHIRL)
        if self.onset is None:
            kind = "Swing in a plane, which is no whirl" if self.recorded.swings else "No whirl"
            return f"{kind}, at {self.point}; {size}."
        frequency, ratio = self.summary["whirl_frequency_hz"], self.summary["whirl_ratio"]
        pace = "" if frequency is None else f" at {frequency:.2f} Hz, {ratio:.2f} of the rotation"
        end, lasts = self.summary["whirl_end_s"], lasting(self.summary)
        until = "" if end is None else f" to {end:.2f} s"
        after = "" if end is None else f"; at the end {lasts}"
        then = "" if self.at_onset == self.point else f", with {self.at_onset} at its onset"
        last = " at the end" if then and not after else ""
        start = f"Whirl from {self.onset:.2f} s{until} at {self.summary['onset_mark']}{then}"
        return f"{start}: {self.kind or 'no single kind'}{pace}{after}, at {self.point}{last}; {size}."

    @property
    def kind(self) -> str:
        """Motion of the whirl in words: the motion that lasts; of a whirl that ended the longest between its ends."""
        if (end := self.summary["whirl_end_s"]) is None:
            return lasting(self.summary)
        spent = Counter[str]()
        for one in self.summary["motion"]:
            if one["state"] not in CALM:
                spent[one["state"]] += max(0.0, min(one["end_s"], end) - max(one["start_s"], self.onset or 0.0))
        return max(spent, key=lambda state: spent[state], default="") if any(spent.values()) else ""

    def motion_text(self, problem: str) -> str:
        """Axial motion or torsion of the run."""
        kind = f"{self.summary['bit']}".capitalize() if problem == TORSION else "Axial motion"
        return f"{kind}, at {self.point}; {self.recorded.text(problem)}."

    def mode_text(self, table: ModeTable | None, fastest: Mode | None) -> str:
        """The mode that grows fastest and the one nearest to the whirl."""
        if table is None or fastest is None:
            return f"Modes are not known ({self.unknown_modes or 'none lateral'})."
        where = "about the axis of the hole" if table.on_axis else "about the balance on the wall"
        if self.units.set_point(self.steady.weight_on_bit, self.steady.rotation) != self.point:
            where += " at the onset"
        frequency, lines = self.summary["whirl_frequency_hz"], self.summary["spectrum_lines"]
        if frequency is None and lines:
            frequency = lines[0]["frequency_hz"]
        text = f"Small motion {where}: the lateral mode at {fastest.frequency:.2f} Hz {rate(fastest.growth)}"
        if slow := self.slow(fastest.growth):
            return f"{text}{slow}."
        if fastest.growth > 0.0:
            later = ": whirl would come later" if self.onset is None else ""
            return f"{text}, the fastest growth{later}."
        if self.onset is None or frequency is None:
            return f"{text}, the slowest decay."
        near = min(table.of(LATERAL), key=lambda mode: abs(mode.frequency - frequency))
        return (
            f"Small motion {where} decays, so it is not what whirls by itself; the lateral mode nearest to the "
            f"whirl, at {near.frequency:.2f} Hz, {rate(near.growth)}."
        )

    def causes(self, problem: str, trials: tuple[Trial, ...], *, buckled: bool) -> list[Trial]:
        """Repeats that name the cause: the longer one where the motion dies away, else effects, else less weight."""
        if (problem == TORSION and self.recorded.decays) or problem in trials[0].cures:
            return [trials[0]]
        cures = [trial for trial in trials if problem in trial.cures]
        of_weight = [trial for trial in cures if buckled and problem == WHIRL and "of the weight" in trial.change]
        return [trial for trial in cures if trial.of_effects] or of_weight

    def named(self, problem: str, causes: list[Trial], trials: tuple[Trial, ...]) -> str:
        """The cause of a problem, or what was checked."""
        of = f" of the {problem}" * (len(self.problems) > 1 or problem != WHIRL)
        if not causes:
            told = "; ".join(f"{trial.change}: {trial.outcome}" for trial in trials if trial.of_effects)
            return f"The cause{of} is not known; repeats of the run that were checked: {told or 'none'}."
        found = "; ".join(f"{trial.change}: {trial.outcome}" for trial in causes)
        if causes[0] is trials[0]:
            return f"Cause{of}: what the start set off, which dies away; {found}."
        if not causes[0].of_effects:
            return f"Cause{of}: the weight buckles the string; {found}."
        forced = problem == WHIRL and self.kind == MotionState.SYNCHRONOUS_WHIRL.value
        each = " (each change alone takes it away)" * (len(causes) > 1)
        names = " and ".join(SOFT if one.change == STIFF else one.change.removeprefix("without ") for one in causes)
        told = f"{found[0].upper()}{found[1:]}"
        return f"Cause{of}{' (forced, at the speed of rotation)' * forced}{each}: {names}. {told}."

    def cures(self, problem: str, trials: list[Trial]) -> str:
        """Sentence on which of less weight, speed or wall friction cures a problem."""
        of = f" of the {problem}" * (len(self.problems) > 1)
        if found := [f"{trial.change}: {trial.outcome}" for trial in trials if problem in trial.cures]:
            return f"Cure{of}: {'; '.join(found)}."
        return f"None of these cures it{of}: {', '.join(trial.change for trial in trials)}." if trials else ""


def buckling(scene: Scene, command: Command) -> float | None:
    """Growth of the fastest lateral mode under the weight of a command, without rotation [1/s]; None without one.

    Raises:
        RunError: There is no balance.
    """
    at_rest = modes_under(scene, Command(command.weight_on_bit, 0.0)).fastest(LATERAL)
    return None if at_rest is None else at_rest.growth
