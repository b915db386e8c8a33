# SPDX-License-Identifier: Apache-2.0
"""Values that a run reports of itself in `/diagnostics`: timing, rejected frames, energy balance, effects left out."""

import time
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress

import numpy as np

from drill_twin.core.numerals import whole_number
from drill_twin.dynamics.discretisation.joint import JointMotion
from drill_twin.dynamics.twin.frame import EnergyBalance, Frames, RigState, StepStats
from drill_twin.physics.model.mesh import Rod
from drill_twin.physics.model.section_stress import LARGEST_STRESS
from drill_twin.scene import Scene

_FRAMES, _SHORTEST = 10, 0.2  # a window of fewer frames and less time [s] has no rate
EFFORT = ("steps", "iterations", "cut_steps", "steps_above_tolerance")
"""Fields of `StepStats` that are counted."""


class RunTiming:
    """Real-time factor, speed of the physics and step counts, over the whole run and since the last report.

    The real-time factor is simulated over wall time, pauses left out. The speed of the physics is simulated time over
    the time spent computing the motion: the real-time factor of a run that did nothing else and waited for nothing.
    """

    def __init__(self) -> None:
        self.simulated = 0.0
        """Simulated time [s]."""
        self._computing = self._publishing = self._wall = 0.0
        self._effort = Counter[str]()
        self._slowest = self._recent = 0.0
        self._frame_end: float | None = None
        self._window_start: float | None = None
        self._window_simulated, self._window_frames = 0.0, 0

    def update(self, simulated: float, publishing: float, stats: StepStats, frames: int = 1) -> None:
        """Count frames that have just been published.

        Args:
            simulated: Simulated time of all frames [s].
            publishing: Time of encoding and sending all frames [s].
            stats: Numerical effort.
            frames: Number of frames; the slowest frame of a block is not known, so its mean computing time counts.
        """
        now, computing = time.monotonic(), stats.wall_seconds
        start = now - computing - publishing if self._frame_end is None else self._frame_end
        self._frame_end = now
        self._window_start = start if self._window_start is None else self._window_start
        self.simulated += simulated
        self._computing += computing
        self._publishing += publishing
        self._wall += now - start
        self._window_simulated += simulated
        self._window_frames += frames
        self._effort.update({key: getattr(stats, key) for key in EFFORT})
        self._slowest = max(self._slowest, computing / frames)

    def pause(self) -> None:
        """Leave the time until the next frame out of the real-time factor of the run."""
        self._frame_end = None

    def start_window(self) -> None:
        """Start a new reporting window."""
        self._recent = self.recent_realtime_factor
        if self._window_start is not None:
            self._window_start = time.monotonic()
        self._window_simulated, self._window_frames = 0.0, 0

    @property
    def realtime_factor(self) -> float:
        """Simulated over wall time, pauses left out; 0 before the first frame."""
        return _ratio(self.simulated, self._wall)

    @property
    def recent_realtime_factor(self) -> float:
        """Simulated over wall time in this window, or in the last window while this one is too short; 0 in a pause."""
        if self._window_start is None:
            return 0.0
        wall = time.monotonic() - self._window_start
        long_enough = self._window_frames >= _FRAMES or wall >= _SHORTEST
        return _ratio(self._window_simulated, wall) if long_enough else self._recent

    @property
    def physics_speed(self) -> float:
        """Simulated over computing time; 0 before the first frame."""
        return _ratio(self.simulated, self._computing)

    def values(self) -> dict[str, str]:
        """Diagnostics values."""
        return {
            "realtime_factor": f"{self.realtime_factor:.3f}",
            "realtime_factor_last_second": f"{self.recent_realtime_factor:.3f}",
            "physics_speed": f"{self.physics_speed:.3f}",
            "slowest_frame_ms": f"{self._slowest * 1e3:.3f}",
            "publishing_share": f"{_ratio(self._publishing, self.simulated):.4f}",
            **{key: str(self._effort[key]) for key in EFFORT},
        }

    def text(self) -> str:
        """The real-time factor and the speed of the physics as a sentence."""
        if not self.simulated:
            return "nothing simulated yet"
        return f"real-time factor {self.realtime_factor:.3g}, the physics alone {self.physics_speed:.3g}"


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else 0.0


KEY = "left_out"
"""Key in the simulator's diagnostics; several sentences are joined by `SEPARATOR`."""
NOTES = "notes"
"""Key in the simulator's diagnostics for notes on the scene (`drill_twin.dynamics.discretisation.notes`), joined
likewise."""
SEPARATOR = " | "
_BIT_FORCE, _TOP_SPEED = map(RigState._fields.index, ("bit_force", "top_drive_speed"))


def recorded_sentences(values: Mapping[str, str]) -> list[str]:
    """The sentences in the simulator's diagnostics: missing effects, and notes on the scene."""
    return [sentence for key in (KEY, NOTES) if values.get(key) for sentence in values[key].split(SEPARATOR)]


class MissingEffects:
    """Checks every frame for the first sign of a missing effect, or of lateral motion that `lateral_from` cuts off.

    Attributes:
        found: One sentence for each, with time and place, in order of appearance.
    """

    def __init__(self, scene: Scene, rod: Rod) -> None:
        effects, self._units = scene.effects, scene.unit_system
        self._joint = JointMotion(scene, rod)
        self.found: list[str] = []
        self._yielded: set[str] = set()
        self._check_wall = effects.wall is None
        block = effects.fatigue
        self._yield_strengths = {} if block is None else block.yield_strengths(scene)
        self._check_bit = scene.rig.weight_on_bit.at == "top" and not effects.providing("weight")

    def update(self, frames: Frames) -> None:
        """Check frames, in order."""
        if frames.u is not None and frames.v is not None:
            self.found += self._joint.update(frames.time, frames.u, frames.v, frames.rig[:, _TOP_SPEED])
        force, depth = frames.rig[:, _BIT_FORCE], frames.wall_depth
        through, pulled = depth > 0.0, force < 0.0
        for k in np.flatnonzero(through | pulled | (frames.stress is not None)).tolist():
            if not (self._check_wall or self._check_bit or self._yield_strengths):
                return
            time = float(frames.time[k])
            if self._check_wall and through[k]:
                self._check_wall = False
                self.found.append(
                    f"at {time:.3f} s the string passed through the wall of the hole, "
                    f"{self._units.text(float(frames.wall_depth_at[k]), 'length', '.3g')} from the bit, and goes on "
                    "as if there were none: list the effect `wall`"
                )
            if self._check_bit and pulled[k]:
                self._check_bit = False
                self.found.append(
                    f"at {time:.3f} s the bit was pulled with {self._units.text(-float(force[k]), 'force')} and would "
                    "have lifted off the bottom, which holds it here: list `rock_floor`, `bit_cutting` or "
                    "`bit_regenerative`"
                )
            if frames.stress is not None:
                self._check_yield(time, frames.stress[k, :, LARGEST_STRESS].tolist())

    def _check_yield(self, time: float, largest: list[float]) -> None:
        """Check the stress of the sections of `fatigue` [Pa]."""
        for (name, strength), stress in zip(self._yield_strengths.items(), largest, strict=True):
            if stress > strength and name not in self._yielded:
                self._yielded.add(name)
                self.found.append(
                    f"at {time:.3f} s the stress at {name} reached {self._units.text(stress, 'stress')}, above its "
                    f"yield strength of {self._units.text(strength, 'stress')}, and goes on as if it were elastic: its "
                    "damage counts for nothing"
                )

    def values(self) -> dict[str, str]:
        """Diagnostics values; empty while nothing is missing."""
        return {KEY: SEPARATOR.join(self.found)} if self.found else {}


ENERGY = "energy_"
"""Prefix of the keys of the energy balance, present where a scene asks for it: `energy_residual` is the share of
`energy_scale_J`, `energy_work_drag_J` the work of that effect."""
COUNT, NEW, STOP = "guard_interventions", "guard", "guard_stop"
"""Keys in the simulator's diagnostics: number of rejected frames, descriptions of the frames that were rejected since
the last report, and the reason of a stop."""
LARGEST_REPORT = 20
"""Largest number of rejected frames that one report describes."""


class RejectedSteps:
    """Counts the frames that the step guard rejected.

    Attributes:
        count: Number of rejected frames.
        last: Description of the last rejected frame; empty if no frame was rejected.
        stopped: Reason of the stop; empty unless the run was stopped.
    """

    def __init__(self) -> None:
        self.count = 0
        self.last = self.stopped = ""
        self._new: list[str] = []
        self._energy: EnergyBalance | None = None

    def update(self, frames: Frames) -> None:
        """Count the rejected frames among the frames that were computed."""
        self._energy = frames.energy
        texts = [intervention.text for intervention in frames.interventions]
        self.count += len(texts)
        self._new += texts
        self.last = (self.last, *texts)[-1]

    def values(self) -> dict[str, str]:
        """Diagnostics values; each rejected frame is described in one report only."""
        described, remaining = self._new[:LARGEST_REPORT], len(self._new) - LARGEST_REPORT
        self._new = []
        if remaining > 0:
            described.append(f"and {remaining} more")
        values = {COUNT: str(self.count)}
        values |= {key: text for key, text in ((NEW, SEPARATOR.join(described)), (STOP, self.stopped)) if text}
        return values | (energy_values(self._energy) if self._energy else {})


def energy_values(energy: EnergyBalance) -> dict[str, str]:
    """Diagnostics values of an energy balance [J]."""
    parts = {"stored": energy.stored, "work": energy.work, "dissipated": energy.dissipated}
    values = {f"{kind}_{name}_J": value for kind, part in parts.items() for name, value in part.items()}
    values |= {"residual": energy.share, "scale_J": energy.scale, "newton_J": energy.newton}
    return {f"{ENERGY}{key}": repr(float(value)) for key, value in values.items()}


class RecordedRejections:
    """Rejected frames and energy balance of a recorded run, read from the simulator's diagnostics.

    Attributes:
        count: Number of rejected frames.
        events: Their descriptions.
        stopped: Reason of the stop; None unless the run was stopped.
        energy: The last energy balance, by key.
    """

    def __init__(self) -> None:
        self.count = 0
        self.events: list[str] = []
        self.stopped: str | None = None
        self.energy: dict[str, float] = {}

    def update(self, values: Mapping[str, str]) -> None:
        """Read the values of one report."""
        count = whole_number(values.get(COUNT, ""))
        self.count = self.count if count is None else count
        self.events += values[NEW].split(SEPARATOR) if values.get(NEW) else []
        self.stopped = values.get(STOP) or self.stopped
        found = {key.removeprefix(ENERGY): text for key, text in values.items() if key.startswith(ENERGY)}
        with suppress(ValueError):  # a bag of another program may use such a key
            self.energy |= {key: float(text) for key, text in found.items()}

    def summary(self) -> dict[str, object]:
        """Plain types for `summary.json`."""
        return {"interventions": self.count, "events": self.events, "stopped": self.stopped}
