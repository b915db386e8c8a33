# SPDX-License-Identifier: Apache-2.0
"""Cause of the whirl of a run: growth of its modes, and repeats of the run with one effect or set-point taken back."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from drill_twin.api.growth_limits import buckling, limits, modes_under, rate
from drill_twin.api.recorded_run import planned
from drill_twin.api.result import Result
from drill_twin.api.scenes import override
from drill_twin.api.simulation import Simulation
from drill_twin.core.errors import BagError, RunError, SceneError
from drill_twin.core.table import Table
from drill_twin.dynamics.rotordynamics.modes import LATERAL, Mode, ModeTable
from drill_twin.io.bag.virtual_bags import RecordBag
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.report.load_text import Summary, units_of
from drill_twin.report.recording import Recording
from drill_twin.runs.recorded_commands import recorded_commands
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at
from drill_twin.scene.set_points import Command
from drill_twin.whirl import MotionState

AFTER_ONSET = 30.0
"""Simulated time after the onset at which repeats end, where the run is longer [s]."""
LESS = 0.7
"""Share of weight or speed in the repeats with less of it."""
SMALL = 0.1
"""Share of bow and eccentricity that is left. Not zero: a perfect string never leaves the axis of a vertical hole."""

BACKWARD = (MotionState.BACKWARD_WHIRL.value, MotionState.ROLLING.value)
FORWARD = (MotionState.FORWARD_WHIRL.value, MotionState.SYNCHRONOUS_WHIRL.value)

_EFFECTS = {
    "without internal damping": {"internal_damping.bending_time": 0.0},
    "without wall friction": {"wall_friction.coefficient": 0.0, "wall_friction.sliding": 0.0},
    "without friction at the bit": {"bit_friction.coefficient": 0.0},
    "without the random force": {"random_force.rms": 0.0},
    "without shaking of the top": {"top_shake.amplitude": 0.0},
    f"with {SMALL:g} of bow and eccentricity": {
        "bow.amplitude": SMALL, "eccentricity.offset": SMALL, "eccentricity.rms": SMALL,
    },
}  # fmt: skip
"""Repeats: keys of effects, and the share of their value that is left."""


class Trial(NamedTuple):
    """A repeat of the run with one change."""

    change: str
    """In words, such as `without internal damping`."""
    of_effects: bool
    """An effect was taken back, not a set-point."""
    ends_whirl: bool
    """It does not whirl, or not backward where the run does, and would not later: no mode grows."""
    outcome: str
    """Result in words."""
    motion: str
    """Motion that lasts; empty where the repeat could not be followed to its end."""
    frequency_hz: float | None
    """Frequency of its whirl."""
    growth_per_s: float | None
    """Growth of the lateral mode that grows fastest, with this change; None: not known."""


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


def why(result: Result, *, progress: Callable[[str], None] | None = None) -> Cause:
    """Find why a run whirled.

    The lateral modes under the set-points at the end of the run say whether the string leaves its balance by itself.
    Then the run is repeated under its recorded set-points, to 30 s after the onset at most, each time with one change:
    an effect that can feed whirl left out, a tenth of bow and eccentricity, 0.7 of the weight, 0.7 of the speed. An
    effect is named as a cause only where the repeat without it does not whirl, and no mode grows in it.

    >>> print(why(Simulation("pa6_bench", {"wob": 5}).run()))

    Args:
        result: A run, or the bag of one.
        progress: Takes the name of each repeat before it begins.

    Raises:
        BagError: It is the record of a rig, its scene is not known, or it has no rig states.
    """
    return cause_of(result.recording, result.summary, progress=progress)


def cause_of(recording: Recording, summary: Summary, *, progress: Callable[[str], None] | None = None) -> Cause:
    """As `why`, from a recording and its summary."""
    if isinstance(recording.bag, RecordBag) or not recording.scene_known:
        raise BagError(
            f"{recording.path}: expected the bag of a run with its scene, found none; give the scene with --scene"
        )
    return _Search(recording, summary, progress or (lambda _: None)).cause()


class _Search:
    """Repeats and modes of one run."""

    def __init__(self, recording: Recording, summary: Summary, progress: Callable[[str], None]) -> None:
        self.progress, self.summary, self.units = progress, summary, units_of(summary)
        scene = recording.scene
        recorded = recorded_commands(recording.bag, planned(scene), block=scene.rig.moves_block)
        self.scene = override(scene, {"numerics.frame_rate": NANOSECONDS / recorded.period})
        self.command, self.period = recorded.commands[-1], recorded.period / NANOSECONDS
        self.onset: float | None = self.summary["onset_s"]
        frames = len(recorded.commands)
        if self.onset is not None:
            frames = min(frames, math.ceil((self.onset + AFTER_ONSET) / self.period))
        self.commands = recorded.commands[:frames]
        self.unknown_modes = ""

    def cause(self) -> Cause:
        """Sentences, from the modes and all repeats."""
        self.progress("modes")
        table = self.modes(self.scene, self.command)
        fastest = table.fastest(LATERAL) if table else None
        if self.onset is None:
            return Cause((f"The run does not whirl, at {self.point} at its end.", self.mode_text(table, fastest)))
        sentences = [self.what(), self.mode_text(table, fastest)]
        on_axis = table is not None and table.on_axis
        if on_axis and fastest is not None and fastest.growth > 0.0:
            try:
                sentences[-1] += buckling(self.scene, self.command)
                sentences.append(limits(self.scene, self.command, self.units))
            except RunError as error:
                sentences.append(f"The weight and speed at which the growth ends are not known ({error}).")
        trials = tuple(self.trials())
        sentences.insert(2, self.named(trials))
        stops = [f"{trial.change}: {trial.outcome}" for trial in trials if not trial.of_effects]
        sentences.append(f"{_upper('; '.join(stops))}.")
        causes = tuple(trial.change for trial in trials if trial.of_effects and trial.ends_whirl)
        return Cause(tuple(sentences), causes, trials)

    @property
    def point(self) -> str:
        """Weight and speed at the end."""
        return self.units.set_point(self.command.weight_on_bit, self.command.rotation)

    def modes(self, scene: Scene, command: Command) -> ModeTable | None:
        """Modes under a command; None where they cannot be computed, and `unknown_modes` says why."""
        try:
            return modes_under(scene, command)
        except (SceneError, RunError) as error:
            self.unknown_modes = str(error)
            return None

    def trials(self) -> Iterator[Trial]:
        """Repeats: each effect of the scene, then the set-points."""
        for change, shares in _EFFECTS.items():
            blocks = self.scene.effects.blocks
            values = {
                f"effects.{key}": share * old
                for key, share in shares.items()
                if key.split(".")[0] in blocks and (old := number_at(self.scene, f"effects.{key}"))
            }
            if values:
                yield self.trial(change, override(self.scene, values), 1.0, 1.0, of_effects=True)
        for name, weight, speed in (("weight", LESS, 1.0), ("speed", 1.0, LESS)):
            if not (self.command.weight_on_bit if name == "weight" else self.command.rotation):
                continue
            less = Command(weight * self.command.weight_on_bit, speed * self.command.rotation)
            told = self.units.set_point(less.weight_on_bit, less.rotation)
            yield self.trial(f"at {LESS:g} of the {name} ({told})", self.scene, weight, speed, of_effects=False)

    def trial(self, change: str, scene: Scene, weight: float, speed: float, *, of_effects: bool) -> Trial:
        """A repeat with shares of weight and speed."""
        self.progress(f"repeat {change}")

        def less(of: Command) -> Command:
            return Command(weight * of.weight_on_bit, speed * of.rotation, of.block)

        table = self.modes(scene, less(self.command))
        fastest = table.fastest(LATERAL) if table else None
        growth = None if fastest is None else fastest.growth
        simulation = Simulation(scene)
        try:
            simulation.play([less(command) for command in self.commands])
        except RunError as error:
            return Trial(change, of_effects, False, f"could not be followed: {error}", "", None, growth)
        found = simulation.result().summary
        ends, outcome = self.outcome(found, growth)
        return Trial(change, of_effects, ends, outcome, found["lasting_motion"], found["whirl_frequency_hz"], growth)

    def outcome(self, found: Summary, growth: float | None) -> tuple[bool, str]:
        """True where the change ends the whirl of the run, and the result in words."""
        end, motion, frequency = found["whirl_end_s"], found["lasting_motion"], found["whirl_frequency_hz"]
        if found["onset_s"] is None:
            if growth is None:
                return True, "no whirl"
            if growth > 0.0:
                length = len(self.commands) * self.period
                return False, f"no whirl within {length:.3g} s, but a mode {rate(growth)}, so it comes later"
            return True, f"no whirl; the slowest mode {rate(growth)}"
        if end is not None and self.summary["whirl_end_s"] is None:
            return True, f"the whirl ends at {end:.2f} s"
        told = motion if frequency is None else f"{motion} at {frequency:.2f} Hz"
        if self.summary["lasting_motion"] in BACKWARD and motion in FORWARD:
            return True, f"no backward whirl, but {told}"
        return False, f"still whirls: {told}"

    def what(self) -> str:
        """Whirl of the run."""
        frequency, ratio = self.summary["whirl_frequency_hz"], self.summary["precession_ratio"]
        pace = "" if frequency is None else f" at {frequency:.2f} Hz, {ratio:.2f} of the rotation"
        end = self.summary["whirl_end_s"]
        until = "" if end is None else f", which ends at {end:.2f} s"
        return f"Whirl from {self.onset:.2f} s: {self.summary['lasting_motion']}{pace}{until}, at {self.point}."

    def mode_text(self, table: ModeTable | None, fastest: Mode | None) -> str:
        """The mode that grows fastest and the one nearest to the whirl."""
        if table is None or fastest is None:
            return f"Modes are not known ({self.unknown_modes or 'none lateral'})."
        where = "about the axis of the hole" if table.on_axis else "about the balance on the wall"
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

    def named(self, trials: tuple[Trial, ...]) -> str:
        """The cause, or what was checked."""
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
            kind = " (forced, at the speed of rotation)" if forced else ""
            return f"Cause{kind}: {'; '.join(causes)}."
        return f"The cause is not known; repeats of the run that were checked: {'; '.join(told) or 'none'}."


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
