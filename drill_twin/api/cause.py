# SPDX-License-Identifier: Apache-2.0
"""Cause of the whirl of a run: growth of its modes, and repeats of the run with one effect or set-point taken back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from drill_twin.api.growth_limits import buckling, limits, rate
from drill_twin.api.repeats import SWINGS, Repeats, Trial
from drill_twin.api.result import Result
from drill_twin.core.errors import BagError, RunError
from drill_twin.core.table import Table
from drill_twin.dynamics.rotordynamics.modes import LATERAL, Mode, ModeTable
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.report.load_text import Summary
from drill_twin.report.recording import Recording
from drill_twin.report.text import lasting
from drill_twin.whirl import MotionState


@dataclass(frozen=True)
class Cause:
    """Cause of the whirl of a run; `str` gives the sentences."""

    sentences: tuple[str, ...]
    """Motion, mode, the cause, and what would stop it."""
    causes: tuple[str, ...] = ()
    """Changes of effects that end the whirl; empty: the cause is not known, or there is none."""
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
    """Find why a run whirled.

    The lateral modes under the set-points at the onset say whether the string leaves its balance by itself.
    Then the run is repeated under its recorded set-points, to 30 s after the onset at most, each time with one change:
    an effect that can feed whirl left out, a tenth of bow and eccentricity, less of the weight, the speed, the wall
    friction. An effect is named as a cause only where the repeat without it does not whirl, no mode grows in it, and
    its lateral motion is less than half; and so at 0.98 and 1.02 of the speed, where the run itself whirls there.

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
        table = self.modes(self.scene, self.steady)
        fastest = table.fastest(LATERAL) if table else None
        if self.onset is None:
            return Cause((f"The run does not whirl, at {self.point} at its end.", self.mode_text(table, fastest)))
        sentences = [self.what(), self.mode_text(table, fastest)]
        on_axis, sought = table is not None and table.on_axis, "The cause"
        if on_axis and fastest is not None and fastest.growth > 0.0:
            try:
                if buckled := buckling(self.scene, self.steady):
                    sentences[-1] += buckled
                    sought = "Buckling takes it off the axis; what then makes it whirl"
                sentences.append(limits(self.scene, self.steady, self.units))
            except RunError as error:
                sentences.append(f"The weight and speed at which the growth ends are not known ({error}).")
        trials = tuple(self.trials())
        sentences.insert(2, self.named(trials, sought))
        sentences.append(_stops([trial for trial in trials if not trial.of_effects]))
        causes = tuple(trial.change for trial in trials if trial.of_effects and trial.ends_whirl)
        return Cause(tuple(sentences), causes, trials)

    def what(self) -> str:
        """Whirl of the run."""
        frequency, ratio = self.summary["whirl_frequency_hz"], self.summary["whirl_ratio"]
        pace = "" if frequency is None else f" at {frequency:.2f} Hz, {ratio:.2f} of the rotation"
        end = self.summary["whirl_end_s"]
        until = "" if end is None else f", which ends at {end:.2f} s"
        motion = lasting(self.summary)
        index, where = self.summary["stick_slip_index"], self.summary["onset_mark"]
        bit = f", with a stick-slip index of {index:.2f}" if index is not None and index >= SWINGS else ""
        then = "" if self.at_onset == self.point else f", with {self.at_onset} then"
        last = " at the end" if then else ""
        return f"Whirl from {self.onset:.2f} s at {where}{then}: {motion}{pace}{until}, at {self.point}{last}{bit}."

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

    def named(self, trials: tuple[Trial, ...], sought: str) -> str:
        """The cause, or what is sought and was checked."""
        told = [f"{trial.change}: {trial.outcome}" for trial in trials if trial.of_effects]
        causes = [
            f"{trial.change} the same run gives {trial.outcome}"
            if trial.outcome.startswith("no ")
            else f"{trial.change} {trial.outcome}"
            for trial in trials
            if trial.of_effects and trial.ends_whirl
        ]
        if causes:
            forced = self.summary["lasting_motion"] == MotionState.SYNCHRONOUS_WHIRL.value
            return f"Cause{' (forced, at the speed of rotation)' * forced}: {'; '.join(causes)}."
        calm = [trial.change for trial in trials if trial.of_effects and trial.moves]
        alone = f"; {', '.join(calm)} it is no whirl, but more than half of the motion stays" if calm else ""
        return f"{sought} is not known{alone}; repeats of the run that were checked: {'; '.join(told) or 'none'}."


def _stops(trials: Sequence[Trial]) -> str:
    """Sentence on which of less weight, speed or wall friction ends the whirl."""
    if ends := [f"{trial.change}: {trial.outcome}" for trial in trials if trial.ends_whirl]:
        return f"It ends {'; '.join(ends)}."
    return f"None of these ends it: {', '.join(trial.change for trial in trials)}." if trials else ""
