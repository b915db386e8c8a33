# SPDX-License-Identifier: Apache-2.0
"""Ensemble beside a rig, corrected window by window by what is measured."""

import math
from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from numbers import Integral, Real

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import ArgumentError
from drill_twin.core.rig_channels import INSTANT
from drill_twin.scene import Scene
from drill_twin_studies.estimation.doubts import JUMP_WINDOWS, UNEXPLAINED, Doubts, Jumps
from drill_twin_studies.estimation.estimate import (
    UNTOLD,
    Band,
    Estimate,
    FilterWindow,
    Prediction,
    Swing,
    WindowTiming,
    bands_of,
    untold_of,
)
from drill_twin_studies.estimation.innovations import WINDOWS, ChannelErrors, Innovations, widening, widening_of_numbers
from drill_twin_studies.estimation.members import LOAD, EstimatorMembers
from drill_twin_studies.estimation.phase import PhaseCorrection
from drill_twin_studies.estimation.restarts import Restarts
from drill_twin_studies.estimation.square_root_filter import Correction, applied, corrections
from drill_twin_studies.estimation.subs import VALUES, speed
from drill_twin_studies.fitting.sampling import Ranges

CHANNELS = ("torque", "motor_torque", "hookload", "top_drive_speed", "bit_speed")
"""Channels that can correct: the surface channels, and the speed of a downhole tool."""
_CORRECTED = ("weight_on_bit", "bit_speed", "bit_torque")
"""Virtual sensors that the correction of torsion and axial motion changes."""
_LATERAL = ("radius", "bending_stress")
"""Virtual sensors that the correction of the lateral motion changes too; the largest wall force comes from an impact
and follows no correction."""
_FOLLOWED = ("radius", "bit_speed")
"""Virtual sensors whose bands hold with a sub as without."""
_FEW, _IMPACT = 2.0, 1.1
"""Factors of the spread with a sub. A sub corrects a motion in many directions, and few members have too little spread
in them. The first is for the bands of the other virtual sensors, and for what the surface measures where a misfit is
judged. The second is for the band of the largest wall force, which an impact causes. Found on 57 truths of
`pa6_bench`; judged on others (docs/drill_twin_studies/bands.md).
"""
_WHIRLS = 0.5
"""Share of members that whirl, above which none is followed ahead: more than half of them whirl already."""


@dataclass(frozen=True)
class EstimatorOptions:
    """Options of the ensemble: its runs and its assumptions.

    Attributes:
        members: Number of members.
        window: Length of a window [s].
        rate: Samples a second that are compared [Hz].
        error: Error of a sample, of sensor and model together, as a share of the channel's largest value.
        memory: Time over which what was learnt of the numbers fades [s]: the spread grows as exp(t / memory).
        horizon: Time ahead for which the chance of whirl is computed [s]; 0: it is not computed.
        scouts: Members that are followed over the horizon.
        frames: True if estimates have the frames of the nearest member.
        seed: Seed of the draws.
    """

    members: int = 64
    window: float = 1.0
    rate: float = 10.0
    error: float = 0.02
    memory: float = 300.0
    horizon: float = 4.0
    scouts: int = 16
    frames: bool = False
    seed: int = 1

    def __post_init__(self) -> None:
        """Refuse numbers that no ensemble can have.

        Raises:
            ArgumentError: One of them.
        """
        for name, least, most in (
            ("members", 4, 10_000), ("window", 0.05, 3600.0), ("rate", 0.1, 1000.0), ("error", 1e-6, 1.0),
            ("memory", 1.0, math.inf), ("horizon", 0.0, 3600.0), ("scouts", 1, 10_000),
        ):  # fmt: skip
            value = getattr(self, name)
            kind = Integral if isinstance(least, int) else Real
            if not isinstance(value, kind) or not least <= float(value) <= most:
                expected = "a whole number" if kind is Integral else "a number"
                raise ArgumentError(f"{name}: expected {expected} of {least:g} to {most:g}, found {value!r}")


class EnsembleFilter:
    """Ensemble that follows a rig.

    Attributes:
        options: Runs and assumptions.
        members: The ensemble.
        pace: Lengths of frames, samples and windows.
        time: End of the last window [s].
    """

    def __init__(
        self,
        scene: Scene,
        ranges: Ranges,
        channels: Sequence[str],
        options: EstimatorOptions,
        subs: Sequence[str] = (),
        instant: Collection[str] = (),
    ) -> None:
        """Make the ensemble.

        Args:
            scene: The scene.
            ranges: Lowest and highest value of each free number [SI], by key; see
                `drill_twin_studies.estimation.members`.
            channels: Channels that correct, of `CHANNELS`.
            options: Runs and assumptions.
            subs: Subs of the scene whose readings correct.
            instant: Channels whose samples are values at their times; other samples are means since the last sample.

        Raises:
            ArgumentError: A number that cannot be changed in the middle of a run, or a sub that the scene has not.
            SceneError: A range does not fit the scene.
        """
        self.options, self._surface = options, list(channels)
        frame_rate = scene.numerics.frame_rate
        every = max(1, round(frame_rate / options.rate))
        samples = max(1, round(options.window * frame_rate / every))
        self.pace = WindowTiming(scene.numerics.frame_period, every * samples, samples)
        self._computed = [f"{name}{INSTANT}" if name in instant else name for name in channels]
        self.members = EstimatorMembers(scene, ranges, options.members, self.pace, options.seed, subs, self._computed)
        self.channels = [*channels, *(f"{sub.name}/speed" for sub in self.members.subs)]
        self.time = 0.0
        self._errors = ChannelErrors(len(self.channels), options.error)
        few = _FEW if subs else 1.0
        self._innovations = Innovations(self.channels, few)
        self._doubts = Doubts(self.channels)
        self._jumps = Jumps(self.channels, self.members.keys)
        self._restarts = Restarts(self.members, self._computed, few)
        self._phase = PhaseCorrection(self.members, options.error)
        self._unmeasured, self._regained = 0.0, False
        self._swing = Swing(self.pace)
        self._recent: deque[dict[str, Array]] = deque(maxlen=WINDOWS)
        self._distance: Array = np.zeros(options.members)

    def advance(self, window: FilterWindow) -> Estimate:
        """Advance all members by a window, correct them, and return what is known at its end.

        Raises:
            RunError: No member could be followed.
        """
        self._restarts.begin(window)
        nearest = int(np.argmin(self._distance)) if self.options.frames else -1
        frames, prediction = self.members.advance(window, nearest)
        start, self.time, self._regained = self.time, self.time + self.pace.window, False
        predicted, measured, readings = self._compared(prediction, window)
        measured = self._errors.screen(predicted, measured)
        self._restarts.end(measured)
        self._swing.take(prediction.speeds)
        judged = self._innovations
        judged.take(predicted, measured, self._errors.scale, self._errors.stated)
        self._doubts.take(start, judged.surprises, judged.samples, judged.off, self._errors.scale)
        misfit, normalised = judged.misfit, judged.normalised
        anew = self._jumps.take(predicted, self.members.normal, self._errors.stated, normalised)
        found = corrections(predicted, measured, self._errors.deviation)
        lateral = self._phase(self.members, prediction.readings, readings, found) if self.members.subs else []
        corrected = applied(found, predicted)
        self._errors.learn(measured, predicted.mean(axis=0), corrected.mean(axis=0))
        free = [self._jumps.free] * len(found) + [False if self._phase.lost else self._jumps.free] * len(lateral)
        self.members.correct([*found, *lateral], free)
        if anew.any():
            self._start_again(start, anew)
        self._forget()
        sensors = self._sensors(prediction, found, lateral)
        self._recent.append(sensors)
        measuring = window.between or np.isfinite(misfit).any()
        self._unmeasured = 0.0 if measuring else self._unmeasured + self.pace.window
        predicted = np.concatenate((predicted, self._phase.predicted), axis=1)
        measured = np.concatenate((measured, self._phase.measured))
        deviation = np.concatenate((self._errors.deviation, self._phase.errors.deviation))
        off = (applied([*found, *lateral], predicted) - measured) / deviation[:, None]
        self._distance = 0.7 * self._distance + np.nansum(off**2, axis=(1, 2))  # fades over some windows
        goodness = judged.judged()
        withheld = {} if self.members.subs else self._swing.withheld(window.spacing)
        withheld |= dict.fromkeys(sensors, "the model does not explain what is measured") if self._doubts.since else {}
        factor, of_numbers = widening(goodness), widening_of_numbers(goodness)
        estimate = Estimate(
            time=self.time,
            numbers=bands_of(self.members.normal, self.members.ranges, of_numbers),
            untold=untold_of(self.members.normal, self.members.ranges, of_numbers),
            sensors={name: self._band(name, values, factor) for name, values in sensors.items()}
            | dict.fromkeys(withheld, UNTOLD),
            withheld=withheld,
            whirls=float(prediction.whirls.mean()),
            chance=self._chance(window.commands, float(prediction.whirls.mean())),
            unexplained=self._doubts.since,
            jumps=dict(self._jumps.since),
            misfit=dict(zip(self.channels, misfit.tolist(), strict=True)),
            goodness=goodness,
            absurd=self._errors.absurd + self._phase.errors.absurd,
            unmeasured=self._unmeasured,
            frames=frames,
        )
        if estimate.alarm:
            self._doubts.remember(start, self.time)
        return replace(estimate, spans=self._doubts.spans)

    def _start_again(self, start: float, told: Mask) -> None:
        """Follow again with what explains a jump; where nothing does, numbers are held as they were."""
        restart = self._restarts.found(told, self._errors.stated, JUMP_WINDOWS)
        since = start - (JUMP_WINDOWS - 1) * self.pace.window
        self._jumps.explain(since, None if restart is None else restart.chosen)
        if restart is None:
            self.members.set_numbers(self._restarts.held(JUMP_WINDOWS))
            return
        self._regained = not restart.chosen.any()
        self._restarts.follow(restart)
        for each in (self._errors, self._innovations, self._doubts):
            each.forget()

    def _band(self, name: str, values: Array, factor: float) -> Band:
        """Band of a virtual sensor; after an unexplained jump or a lost motion, with all that members did of late."""
        own = Band.of(values, self._wider(name, factor))
        if UNEXPLAINED not in self._jumps.since and not self._regained:
            return own
        late = Band.of(np.concatenate([each[name] for each in self._recent]))
        return replace(own, low=min(own.low, late.low), high=max(own.high, late.high))

    def _wider(self, name: str, factor: float) -> float:
        """Factor of the band of a virtual sensor, from the factor of what is not measured."""
        impact = _IMPACT if name == "wall_force" else 1.0
        if self.members.subs and name not in _FOLLOWED:
            factor = _FEW * max(factor, math.sqrt(self._phase.chi_square))
        if name == "weight_on_bit" and LOAD in self.members.keys:  # known at least as well as before any record
            factor = min(factor, 1.0 / float(self.members.normal[:, self.members.keys.index(LOAD)].std(ddof=1)))
        return impact * factor

    def _compared(self, prediction: Prediction, window: FilterWindow) -> tuple[Array, Array, Array]:
        """Channels of the members, (N, C, S), and of the rig, (C, S), and readings of its subs, (s, F, 6)."""
        pace, subs = self.pace, self.members.subs
        missing = np.full(pace.samples, np.nan)
        readings = np.full((len(subs), pace.frames, VALUES), np.nan) if window.readings is None else window.readings
        predicted = np.stack([prediction.channels[name] for name in self._computed], axis=1)
        measured = np.stack([window.measured.get(name, missing) for name in self._surface])
        speeds = speed(prediction.readings.swapaxes(1, 2), pace.samples)
        return (
            np.concatenate((predicted, speeds), axis=1),
            np.concatenate((measured, speed(readings, pace.samples))),
            readings,
        )

    def _sensors(
        self, prediction: Prediction, found: Sequence[Correction], lateral: Sequence[Correction]
    ) -> dict[str, Array]:
        """Virtual sensors, shape (N,) each, corrected where the corrections change them."""
        changed = (*_CORRECTED, *_LATERAL) if lateral else _CORRECTED
        return {
            name: applied([*found, *lateral], values) if name in changed else values
            for name, values in prediction.sensors.items()
        } | self.members.places

    def _forget(self) -> None:
        """Let the spread of the numbers grow, up to the prior's spread."""
        members, growth = self.members, np.exp(self.pace.window / self.options.memory)
        mean, deviation = members.normal.mean(axis=0), members.normal.std(axis=0)
        members.normal = mean + (members.normal - mean) * np.where(deviation * growth < 1.0, growth, 1.0)

    def _chance(self, commands: Array, whirls: float) -> float:
        """Share of members that whirl within the horizon, if the set-points go on as in this window."""
        windows = round(self.options.horizon / self.pace.window)
        if whirls > _WHIRLS:
            return whirls
        if windows == 0 or not self.members.scene.string.marks:
            return float("nan")
        slope = (commands[-1] - commands[0]) / max(len(commands) - 1, 1)
        steps = np.arange(1, windows * self.pace.frames + 1)[:, None]
        coming = commands[-1] + slope * steps
        coming = np.where(np.sign(coming) == np.sign(commands[-1]), coming, 0.0)
        count = min(self.options.scouts, len(self.members))
        chosen = np.linspace(0, len(self.members) - 1, count).round().astype(int).tolist()
        coming = coming.reshape(windows, self.pace.frames, -1)
        return float(np.mean([self.members.whirls_ahead(number, coming) for number in chosen]))
