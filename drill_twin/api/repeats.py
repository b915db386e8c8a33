# SPDX-License-Identifier: Apache-2.0
"""Repeats of a recorded run with one change: an effect taken back, or less of weight, speed or wall friction."""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drill_twin.api.recorded_run import planned
from drill_twin.api.rotordynamics import modes_under
from drill_twin.api.simulation import Simulation
from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.rotordynamics.modes import LATERAL, ModeTable
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.report.load_text import Summary, units_of
from drill_twin.report.recording import Recording
from drill_twin.report.severity import PROBLEMS, TORSION, WHIRL, Motion, cured
from drill_twin.runs.recorded_commands import recorded_commands
from drill_twin.scene import Scene
from drill_twin.scene.blocks.top_drive import TopDrive
from drill_twin.scene.load import override
from drill_twin.scene.schema import number_at
from drill_twin.scene.set_points import Command
from drill_twin.whirl import MotionState

AFTER_ONSET = 30.0
"""Simulated time after the onset at which repeats end, where the run is longer [s]."""
BEFORE = 1.0
"""Time before the onset over which weight and speed there are averaged [s]."""
LESS = (0.7, 0.5)
"""Shares of weight, speed or wall friction in repeats; the second is tried where the first does not cure the run."""
REACHED = 0.05
"""Share of the set-point's speed from which a difference of the top drive's mean speed is said; chosen, not measured: a
mean over a part of a cycle of stick-slip is off by less."""
BESIDE = (0.98, 1.02)
"""Shares of the speed in further repeats of a change that cures the run: in one run it may do so by chance."""
PUSH = 1e-4
"""Lateral velocity that takes the place of bow and eccentricity [m/s]: a perfect string never leaves the axis of a
vertical hole."""
LONGER = 30.0
"""Time for which a repeat holds the last set-points after the run's end, at least; the run's length where that is more
[s]. What the start set off dies away, and the stick-slip index is of the last 20 s."""

CALM = (MotionState.FIXED_AXIS.value, MotionState.AT_REST.value)
_FRICTION = {"wall_friction.coefficient": "", "wall_friction.sliding": ""}
_UNBALANCE = {"bow.amplitude": "", "eccentricity.offset": "", "eccentricity.rms": ""}
_EFFECTS: dict[str, dict[str, str]] = {
    "without internal damping": {"internal_damping.bending_time": ""},
    "without wall friction": _FRICTION,
    "without friction at the bit": {"bit_friction.coefficient": ""},
    "without the random force": {"random_force.rms": ""},
    "without shaking of the top": {"top_shake.amplitude": ""},
    "without bow and eccentricity": _UNBALANCE,
    "without the fall of the bit's torque with speed": {
        "bit_torque_stribeck.sticking": "bit_torque_stribeck.sliding", "bit_torque_tanh.excess": "",
    },
    "without the torque of cutting": {"bit_cutting.digging": ""},
    "without regeneration at the bit": {"bit_regenerative.regeneration": ""},
}  # fmt: skip
"""Repeats: keys of effects, and the key whose value each takes (empty: zero)."""
STIFF = "with a top drive that holds its speed"


class Trial(NamedTuple):
    """A repeat of the run with one change."""

    change: str
    """In words, such as `without internal damping`."""
    of_effects: bool
    """An effect was taken back, not a set-point."""
    cures: tuple[str, ...]
    """Problems of the run (`PROBLEMS`) that the repeat, and the repeats beside it, do not have."""
    outcome: str
    """Result in words."""
    growth_per_s: float | None
    """Growth of the fastest lateral mode with this change; None where it is not known or the repeat whirls."""


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
        late = recording.rig.top_drive_speed[recording.rig.time >= summary["settled_s"]]
        asked = np.mean([one.rotation for one in recorded.commands[-late.size :]]) if late.size else 0.0
        share = float(np.nanmean(late) / asked) if asked else 1.0
        self.reached = share if abs(share - 1.0) > REACHED else 1.0
        """Share of the set-point's speed that the top drive reached on average; 1 within `REACHED`."""
        if self.onset is not None:
            frames = min(frames, math.ceil((self.onset + AFTER_ONSET) / self.period))
        self.is_whole = frames == len(recorded.commands)
        self.commands, self.rig, self.unknown_modes = recorded.commands[:frames], recording.rig, ""
        self.recorded = Motion(summary, self.scene.severity_bounds)
        self.problems = tuple(problem for problem in PROBLEMS if self.recorded.has(problem))

    @cached_property
    def run(self) -> Motion:
        """Motion of the unchanged run, as long as its repeats."""
        return self.recorded if self.is_whole else self.played(self.scene, 1.0, 1.0)

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
        found = [("", change, scene, 1.0, 1.0) for change, keys in _EFFECTS.items() if (scene := self.scaled(keys))]
        if self.scene.rig.top_drive.model != "prescribed":
            rig = self.scene.rig.model_copy(update={"top_drive": TopDrive()})
            found.append(("", STIFF, self.scene.model_copy(update={"rig": rig}), 1.0, self.reached))
        for name in ("weight", "speed", "wall friction"):
            turns = self.reached * self.command.rotation
            held = {"weight": self.command.weight_on_bit, "speed": turns}.get(name, 1.0)
            for less in LESS if held else ():
                weight = less if name == "weight" else 1.0
                speed = less * self.reached if name == "speed" else 1.0
                of_friction = name == "wall friction"
                scene = self.scaled(_FRICTION, less) if of_friction else self.scene
                told = self.units.set_point(weight * self.command.weight_on_bit, speed * self.command.rotation)
                if scene:
                    change = f"at {less:g} of the {name}{'' if of_friction else f' ({told})'}"
                    found.append((name, change, scene, weight, speed))
        return found

    def trials(self) -> Iterator[Trial]:
        """Repeats: the run held for longer, then `plans`; the second share only where the first does not cure it."""
        plans = self.plans()
        self.progress("repeat held for longer", 0, len(plans) + 1)
        more = self.horizon - self.period * len(self.commands)
        yield (trial := self.trial(f"held for {more:.3g} s longer", self.scene, more=more))
        if len(trial.cures) == len(self.problems):
            return
        cured = set[str]()
        for done, (less, change, scene, weight, speed) in enumerate(plans, 1):
            if less not in cured:
                self.progress(f"repeat {change}", done, len(plans) + 1)
                yield (trial := self.trial(change, scene, weight, speed, of_effects=not less))
                if less and len(trial.cures) == len(self.problems):
                    cured.add(less)

    def scaled(self, keys: Mapping[str, str], share: float = 0.0) -> Scene | None:
        """The scene with a share of numbers of its effects, or with other numbers; None where nothing changes."""
        scene, values = self.scene, dict[str, float]()
        for key, source in keys.items():
            block, field = key.split(".")
            old = getattr(scene.effects.blocks.get(block), field, None)
            new = (number_at(scene, f"effects.{source}") if source else share * old) if old else None
            if new is not None and new != old:
                values[f"effects.{key}"] = new if old is not True else False
        kick = scene.effects.lateral_kick
        if keys is _UNBALANCE and values and not (kick and (kick.velocity or kick.offset)):
            values["effects.lateral_kick.velocity"] = PUSH
        return override(scene, values) if values else None

    def trial(
        self, change: str, scene: Scene, weight: float = 1.0, speed: float = 1.0, *, of_effects: bool = False,
        more: float = 0.0,
    ) -> Trial:  # fmt: skip
        """A repeat with shares of weight and speed, or `more` time [s]; repeats beside it where it cures the run."""
        try:
            found, growth = self.played(scene, weight, speed, more), None
            seems = WHIRL in self.problems and cured(WHIRL, self.run, found, None, less=not of_effects)
            if seems and not found.whirls:
                table = self.modes(scene, Command(weight * self.command.weight_on_bit, speed * self.command.rotation))
                fastest = table.fastest(LATERAL) if table else None
                growth = None if fastest is None else fastest.growth
            outcome = "; ".join(self.told(problem, found, growth) for problem in self.problems)
            fast = growth if self.matters(growth) else None
            cures = [one for one in self.problems if cured(one, self.run, found, fast, less=not of_effects)]
            beside: Mapping[float, Motion] = self.beside if cures and not more else {}
            held_speed = self.reached if speed == 1.0 else speed
            again = {share: self.played(scene, weight, held_speed * share) for share in beside}
            for problem in tuple(cures):
                before = [share for share, motion in beside.items() if motion.has(problem)]
                held = [cured(problem, beside[share], again[share], fast, less=not of_effects) for share in before]
                if not all(held) or (self.reached != 1.0 and not more and not held):  # at no speed that is held
                    cures.remove(problem)
                shares = ", ".join(f"{share:g}" for share in before)
                outcome += f" ({sum(held)} of {len(held)} at {shares} of the speed)" if held else " (one repeat)"
        except RunError as error:
            return Trial(change, of_effects, (), f"could not be followed: {error}", None)
        return Trial(change, of_effects, tuple(cures), outcome, growth)

    def played(self, scene: Scene, weight: float, speed: float, more: float = 0.0) -> Motion:
        """Motion of a scene under shares of the recorded weight and speed; the last set-points hold for more time [s].

        Raises:
            RunError: The run stops early.
        """
        simulation = Simulation(scene)
        commands = [*self.commands, *[self.commands[-1]] * round(more / self.period)]
        simulation.play([Command(weight * one.weight_on_bit, speed * one.rotation, one.block) for one in commands])
        return Motion(simulation.result().summary, self.scene.severity_bounds)

    @cached_property
    def beside(self) -> dict[float, Motion]:
        """Motion of the unchanged run at `BESIDE`, by the share of the speed."""
        return {share: self.played(self.scene, 1.0, share * self.reached) for share in BESIDE}

    @property
    def horizon(self) -> float:
        """Time of the longest repeat [s]."""
        run = self.period * len(self.commands)
        return run + max(LONGER, run)

    def matters(self, growth: float | None) -> bool:
        """True where a growth [1/s] multiplies a motion by e or more within the longest repeat."""
        return growth is not None and growth * self.horizon > 1.0

    def told(self, problem: str, found: Motion, growth: float | None) -> str:
        """Outcome of a repeat for one problem, in words."""
        size, summary = f"({found.text(problem)})", found.summary
        if problem != WHIRL:
            return f"{summary['bit'] if problem == TORSION else problem} {size}"
        left = found.size(WHIRL) / self.run.size(WHIRL)
        size += f", {left:.0%} of the run's" if math.isfinite(left) else ""
        if not found.whirls:
            told = f"no whirl {size}"
            if growth is not None:
                told += f"; {'but a' if growth > 0.0 else 'the slowest'} mode {rate(growth)}{self.slow(growth)}"
            return told + ", so it comes later" * self.matters(growth)
        if (end := summary["whirl_end_s"]) is not None:
            return f"the whirl ends at {end:.2f} s {size}"
        if (motion := summary["lasting_motion"]) in CALM:
            return f"whirls from {summary['onset_s']:.2f} s, for a part of the time {size}"
        pace = "" if (frequency := summary["whirl_frequency_hz"]) is None else f" at {frequency:.2f} Hz"
        return f"{motion}{pace} {size}"

    def slow(self, growth: float) -> str:
        """Words on a growth that does not matter."""
        return (
            f", too slowly to matter within {self.horizon:.3g} s" if growth > 0.0 and not self.matters(growth) else ""
        )


def rate(growth: float) -> str:
    """Growth or decay [1/s] in words."""
    return f"grows with {growth:.2g} 1/s" if growth > 0.0 else f"decays with {-growth:.2g} 1/s"
