# SPDX-License-Identifier: Apache-2.0
"""Repeats of a recorded run with one change: an effect taken back, or less of weight, speed or wall friction."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drill_twin.api.growth_limits import modes_under, rate
from drill_twin.api.recorded_run import planned
from drill_twin.api.result import Result
from drill_twin.api.simulation import Simulation
from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.rotordynamics.modes import LATERAL, ModeTable
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.report.load_text import Summary, units_of
from drill_twin.report.recording import Recording
from drill_twin.runs.recorded_commands import recorded_commands
from drill_twin.scene import Scene
from drill_twin.scene.load import override
from drill_twin.scene.schema import number_at
from drill_twin.scene.set_points import Command
from drill_twin.whirl import MotionState

AFTER_ONSET = 30.0
"""Simulated time after the onset at which repeats end, where the run is longer [s]."""
BEFORE = 1.0
"""Time before the onset over which weight and speed there are averaged [s]."""
LESS = (0.7, 0.5)
"""Shares of weight, speed or wall friction in repeats; the second is tried where the first does not end the whirl."""
BESIDE = (0.98, 1.02)
"""Shares of the speed in further repeats of a change that ends the whirl: in one run it may end by chance."""
LEFT = 0.5
"""Share of the run's lateral motion above which a repeat without whirl still moves as the run does."""
SWINGS = 0.5
"""Stick-slip index of the run from which the repeats tell theirs: friction at the wall brakes the rotation too."""
SMALL = 0.1
"""Share of bow and eccentricity that is left. Not zero: a perfect string never leaves the axis of a vertical hole."""

BACKWARD = (MotionState.BACKWARD_WHIRL.value, MotionState.ROLLING.value, MotionState.CREEPING.value)
CALM = (MotionState.FIXED_AXIS.value, MotionState.AT_REST.value)
FORWARD = (MotionState.FORWARD_WHIRL.value, MotionState.SYNCHRONOUS_WHIRL.value)

_FRICTION = ("wall_friction.coefficient", "wall_friction.sliding")
_EFFECTS = {
    "without internal damping": {"internal_damping.bending_time": 0.0},
    "without wall friction": dict.fromkeys(_FRICTION, 0.0),
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
    """The repeat does not whirl, or not backward where the run does, and would not whirl later: no mode grows, and its
    lateral motion is small. Nor does it whirl at the other speeds at which the run itself whirls."""
    outcome: str
    """Result in words."""
    motion: str
    """Motion of the repeat that lasts; empty where the repeat could not be followed to its end."""
    frequency_hz: float | None
    """Frequency of the repeat's whirl; None without one."""
    growth_per_s: float | None
    """Growth of the fastest lateral mode with this change; None where it is not known or the repeat whirls."""
    moves: bool = False
    """The repeat does not whirl and would not later, but more than `LEFT` of the run's lateral motion is left."""


class Repeats:
    """Repeats and modes of one run."""

    def __init__(self, recording: Recording, summary: Summary, progress: Callable[[str, float, float], None]) -> None:
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
        self.moving, self.rig, self.unknown_modes = self.motion(recording), recording.rig, ""

    @property
    def point(self) -> str:
        """Weight and speed at the end."""
        return self.units.set_point(self.command.weight_on_bit, self.command.rotation)

    @property
    def steady(self) -> Command:
        """Weight and speed of the modes: means of `BEFORE` up to the onset, else the values at the end."""
        if self.onset is None:
            return self.command
        last = min(max(round(self.onset / self.period), 1), len(self.commands))
        before = self.commands[max(0, last - round(BEFORE / self.period)) : last]
        weight, speed = np.mean([(command.weight_on_bit, command.rotation) for command in before], axis=0).tolist()
        return Command(weight, speed)

    @property
    def at_onset(self) -> str:
        """Weight on the bit and speed of the top drive at the onset, means of `BEFORE`."""
        time, last = self.rig.time, self.onset or 0.0
        before = (time > last - BEFORE) & (time <= last)
        weight, speed = self.rig.bit_force[before], self.rig.top_drive_speed[before]
        return self.units.set_point(float(np.nanmean(weight)), float(np.nanmean(speed)))

    def modes(self, scene: Scene, command: Command) -> ModeTable | None:
        """Modes under a command; None where they cannot be computed, and `unknown_modes` says why."""
        try:
            return modes_under(scene, command)
        except (SceneError, RunError) as error:
            self.unknown_modes = str(error)
            return None

    def plans(self) -> list[tuple[str, str, Scene, float, float]]:
        """Repeats, each as five values.

        They are the quantity that is lowered (empty where an effect is taken back), the change in words, the scene,
        and the shares of the recorded weight and speed.
        """
        found = [("", change, scene, 1.0, 1.0) for change, shares in _EFFECTS.items() if (scene := self.scaled(shares))]
        for name in ("weight", "speed", "wall friction"):
            held = {"weight": self.command.weight_on_bit, "speed": self.command.rotation}.get(name, 1.0)
            for less in LESS if held else ():
                weight, speed = (less if name == part else 1.0 for part in ("weight", "speed"))
                of_friction = name == "wall friction"
                scene = self.scaled(dict.fromkeys(_FRICTION, less)) if of_friction else self.scene
                told = self.units.set_point(weight * self.command.weight_on_bit, speed * self.command.rotation)
                if scene:
                    change = f"at {less:g} of the {name}{'' if of_friction else f' ({told})'}"
                    found.append((name, change, scene, weight, speed))
        return found

    def trials(self) -> Iterator[Trial]:
        """Repeats after `plans`; the second share only where the first does not end the whirl."""
        plans, ended = self.plans(), set()
        for done, (less, change, scene, weight, speed) in enumerate(plans):
            if less not in ended:
                self.progress(f"repeat {change}", done, len(plans))
                yield (trial := self.trial(change, scene, weight, speed, of_effects=not less))
                if less and trial.ends_whirl:
                    ended.add(less)

    def scaled(self, shares: Mapping[str, float]) -> Scene | None:
        """The scene with shares of numbers of its effects; None where it has none of them."""
        values = {
            f"effects.{key}": share * old
            for key, share in shares.items()
            if key.split(".")[0] in self.scene.effects.blocks and (old := number_at(self.scene, f"effects.{key}"))
        }
        return override(self.scene, values) if values else None

    def trial(self, change: str, scene: Scene, weight: float, speed: float, *, of_effects: bool) -> Trial:
        """A repeat with shares of weight and speed, and further ones beside it where it ends the whirl."""
        try:
            played = self.played(scene, weight, speed)
            growth, found = None, played.summary
            if found["onset_s"] is None:
                table = self.modes(scene, Command(weight * self.command.weight_on_bit, speed * self.command.rotation))
                fastest = table.fastest(LATERAL) if table else None
                growth = None if fastest is None else fastest.growth
            ends, outcome = self.outcome(played, growth)
            moves = found["onset_s"] is None and not ends and not (growth is not None and growth > 0.0)
            if ends:
                beside = [
                    self.outcome(self.played(scene, weight, speed * share), growth)[0] for share in self.whirls_beside
                ]
                ends = all(beside)
                shares = ", ".join(f"{share:g}" for share in self.whirls_beside)
                outcome += f" ({sum(beside)} of {len(beside)} at {shares} of the speed)" if beside else " (one repeat)"
        except RunError as error:
            return Trial(change, of_effects, False, f"could not be followed: {error}", "", None, None)
        motion, frequency = found["lasting_motion"], found["whirl_frequency_hz"]
        return Trial(change, of_effects, ends, outcome, motion, frequency, growth, moves)

    def played(self, scene: Scene, weight: float, speed: float) -> Result:
        """Run of a scene under shares of the recorded weight and speed.

        Raises:
            RunError: The run stops early.
        """
        simulation = Simulation(scene)
        simulation.play([Command(weight * one.weight_on_bit, speed * one.rotation, one.block) for one in self.commands])
        return simulation.result()

    @cached_property
    def whirls_beside(self) -> tuple[float, ...]:
        """Shares of the speed, of `BESIDE`, at which the run itself whirls."""
        return tuple(share for share in BESIDE if self.played(self.scene, 1.0, share).summary["onset_s"] is not None)

    def motion(self, recording: Recording) -> float:
        """Lateral motion about its mean at the mark of the onset, in the second half of a repeat: rms [m], or NaN."""
        time, names = recording.marks.time, [place.name for place in recording.places]
        end = self.period * len(self.commands)
        late = (time >= 0.5 * end) & (time <= end)
        if self.summary["onset_mark"] not in names or not late.any():
            return math.nan
        centre = recording.centre_lines()[late, names.index(self.summary["onset_mark"])]
        return float(np.sqrt(np.nanmean(np.abs(centre - np.nanmean(centre)) ** 2)))

    def outcome(self, played: Result, growth: float | None) -> tuple[bool, str]:
        """True where the change ends the whirl of the run, and the result in words."""
        found = played.summary
        end, motion, frequency = found["whirl_end_s"], found["lasting_motion"], found["whirl_frequency_hz"]
        left = self.motion(played.recording) / self.moving
        lateral = f", {left:.0%} of the lateral motion" if math.isfinite(left) else ""
        if found["onset_s"] is None:
            if growth is not None and growth > 0.0:
                length = len(self.commands) * self.period
                return False, f"no whirl within {length:.3g} s{lateral}, but a mode {rate(growth)}, so it comes later"
            told = f"no whirl{lateral}"
            if (self.summary["stick_slip_index"] or 0.0) >= SWINGS and found["stick_slip_index"] is not None:
                told += f", stick-slip index {found['stick_slip_index']:.2f}"
            return not left > LEFT, told if growth is None else f"{told}; the slowest mode {rate(growth)}"
        if end is not None and self.summary["whirl_end_s"] is None:
            return True, f"the whirl ends at {end:.2f} s"
        if motion in CALM:
            return False, f"whirls from {found['onset_s']:.2f} s, for a part of the time{lateral}"
        told = motion if frequency is None else f"{motion} at {frequency:.2f} Hz"
        if self.summary["lasting_motion"] in BACKWARD and motion in FORWARD:
            return True, f"no backward whirl, but {told}{lateral}"
        return False, f"still whirls: {told}{lateral}"
