# SPDX-License-Identifier: Apache-2.0
"""Members of the ensemble: twins of one scene with numbers of their own, advanced window by window."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import special

from drill_twin.api.scenes import takes, which_fit
from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import ArgumentError, DrillTwinError, RunError
from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL
from drill_twin.dynamics.twin.dynamics import kernel_of
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.dynamics.twin.frame_record import RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.messages.topic_words import SENSORS
from drill_twin.physics.model.section_stress import bending_stress
from drill_twin.runs.ensemble.outputs import Channels, Instants, Request
from drill_twin.scene import Scene
from drill_twin.scene.load import override
from drill_twin.scene.overrides import full_key
from drill_twin.whirl import criteria
from drill_twin_studies.estimation.estimate import FilterWindow, Prediction, WindowTiming
from drill_twin_studies.estimation.square_root_filter import Correction, applied
from drill_twin_studies.estimation.subs import VALUES, LateralMotion, SubReader, asynchronous_radius, listed
from drill_twin_studies.fitting.sampling import Ranges, in_ranges, sobol

LOAD = "load_factor"
"""Number that is no key of a scene: weight on bit of a member over the weight that is commanded or indicated."""
_TAIL = "tail"
"""Name of the frames before a window among the arrays of a checkpoint."""
WIDEST, FARTHEST = 4.0, 2.5
"""Standard deviations to which a number of a member, and the mean of the members, may move in the space where the prior
of the number is standard normal: all members at one end of a range would have no spread, and none would come back."""
_INWARD = 0.95
"""Step of numbers that do not fit together towards numbers that do; chosen."""


class EstimatorMembers:
    """N twins.

    Attributes:
        scene: The scene of which they are variants.
        ranges: Lowest and highest value of each free number [SI], by key.
        keys: Keys of the free numbers.
        pace: Frames, samples and windows.
        channels: Names of what the twins compute at the frames.
        subs: Downhole subs.
        lateral: Lateral motion of the twins.
        normal: Free numbers in the space where their prior is standard normal, shape (N, d).
        twins: The twins.
    """

    def __init__(
        self,
        scene: Scene,
        ranges: Ranges,
        count: int,
        pace: WindowTiming,
        seed: int,
        subs: Sequence[str] = (),
        channels: Sequence[str] = (),
    ) -> None:
        """Draw the numbers and make the twins, each with a seed of its own; they compute the C channels named.

        Raises:
            ArgumentError: A number that cannot be changed in the middle of a run, or a sub that the scene has not.
            SceneError: A range does not fit the scene.
        """
        self.scene, self.ranges, self.pace, self.channels = scene, ranges, pace, list(channels)
        self.keys, self.subs = list(ranges), listed(scene, subs)
        self._full = {key: full_key(key, scene) for key in self.keys if key != LOAD}
        self._seeds = [seed + number + 1 for number in range(count)]
        self._check()
        drawn = sobol(len(ranges), count, np.random.default_rng(seed))
        self.normal: Array = special.ndtri(np.clip(drawn, 1e-4, 1.0 - 1e-4))
        fit = which_fit(scene, map(self._overrides, self.values))
        self._middle = self.normal[fit].mean(axis=0)
        self.twins = [Twin(self._scene(number)) for number in range(count)]
        self.lateral, self._reader = LateralMotion(scene, self.twins[0]), SubReader(scene, self.twins[0], self.subs)
        self._record = self.twins[0].record(pace.frames, nodes=bool(self.subs))
        self._tail: Array = np.zeros((count, len(channels), pace.tail))  # frames before the window
        clearances = np.array([scene.clearance_at(mark.distance_from_bit) for mark in scene.string.marks])
        self._onset = criteria.ONSET_RADIUS * clearances

    def __len__(self) -> int:
        """Number of members."""
        return len(self._seeds)

    @property
    def values(self) -> Array:
        """Free numbers [SI], shape (N, d)."""
        return in_ranges(special.ndtr(self.normal), self.ranges)

    def advance(self, window: FilterWindow, shown: int = -1) -> tuple[Frames | None, Prediction]:
        """Advance by a window; a member that fails becomes a copy of a member that runs on.

        Args:
            window: Set-points, and times of the samples.
            shown: Number of the member whose frames are returned; -1: none.

        Raises:
            RunError: No member could be followed.
        """
        found, failed, reason = {}, [], ""
        frames = self._frames(shown, window.commands) if shown >= 0 else None
        for number in range(len(self)):
            try:
                found[number] = self._advance(number, window.commands)
            except DrillTwinError as error:
                failed.append(number)
                reason = str(error)
        if not found:
            raise RunError(f"no member could be followed: {reason}")
        for number in failed:
            source = list(found)[number % len(found)]
            self.copy(source, number)
            found[number] = found[source]
        columns = [found[number] for number in range(len(self))]
        channels = self._sampled(slice(None), np.array([each[0] for each in columns]), window)
        sensors = {name: np.array([each[1][name] for each in columns]) for name in SENSORS}
        whirls, readings, speeds = (np.array([each[k] for each in columns]) for k in (2, 3, 4))
        return frames, Prediction(channels, sensors, whirls, readings, speeds)

    def _sampled(self, members: int | slice, frames: Array, window: FilterWindow) -> dict[str, Array]:
        """Channels of a member, (S,) each, or of all, (N, S), over the samples of a window, from their frames."""
        whole = np.concatenate((self._tail[members], frames), axis=-1)
        self._tail[members] = whole[..., -self.pace.tail :]
        sampled = np.einsum("...cf,cfs->c...s", whole, window.weights)
        return dict(zip(self.channels, sampled, strict=True))

    def checkpoint(self, number: int) -> dict[str, Array]:
        """Copy the state of a member, for `replay`: of its twin, and its frames before the window."""
        return self.twins[number].checkpoint() | {_TAIL: self._tail[number].copy()}

    def copy(self, source: int, target: int) -> None:
        """Give a member the state and the seed of another; it keeps its numbers."""
        twin, self._tail[target] = self.twins[target], self._tail[source]
        twin.restore(self.twins[source].checkpoint())
        self._seeds[target] = self._seeds[source]
        twin.change_numbers(self.twins[source].scene)  # whose numbers its arrays have now
        twin.change_numbers(self._scene(target))

    def correct(self, found: Sequence[Correction], free: Sequence[Mask | bool] = ()) -> None:
        """Correct torsional motion and numbers: each correction the numbers of its mask, shape (d,); without, all.

        Surface channels of a straight hole do not change when the lateral motion is turned about its axis, so they are
        uncorrelated with it; a sub corrects it (`drill_twin_studies.estimation.phase`). Axial motion follows loads and
        lateral motion (a bent string is shorter) within the time of a wave: moved by itself it would stretch the string
        and throw it against the wall.
        """
        for correction, mask in zip(found, free or [True] * len(found), strict=True):
            moved = correction.apply_to_numbers(self.normal)
            mean = moved.mean(axis=0)
            within = np.clip(mean, -FARTHEST, FARTHEST)
            self.normal = np.where(mask, np.clip(moved - mean + within, -WIDEST, WIDEST), self.normal)
        self._tail = applied(found, self._tail)  # means that go on in the next window are of the corrected motion
        columns = (6,) if self.twins[0].dynamics.form != LATERAL else ()
        for part in range(2):
            rows = [twin.unknowns[part] for twin in self.twins]
            corrected = applied(found, np.array([row[:, columns] for row in rows]))
            for row, values in zip(rows, corrected, strict=True):
                row[:, columns] = values
        self._write()

    def _write(self) -> None:
        for number, twin in enumerate(self.twins):
            twin.change_numbers(self._scene(number))

    def set_numbers(self, normal: Array) -> None:
        """Give the members other numbers, shape (N, d); they keep their motion."""
        self.normal = normal.copy()
        self._write()

    def replay(
        self, number: int, state: Mapping[str, Array], windows: Sequence[FilterWindow]
    ) -> list[dict[str, Array]]:
        """Set a member back to a checkpoint, and advance it with the numbers that it has now; returns its channels.

        Args:
            number: Number of the member.
            state: `checkpoint` of the member.
            windows: The windows, as of `advance`.

        Raises:
            DrillTwinError: The member cannot be followed.
        """
        self.twins[number].restore(state)
        self.twins[number].change_numbers(self._scene(number))
        self._tail[number] = state[_TAIL]
        return [self._sampled(number, self._advance(number, window.commands)[0], window) for window in windows]

    @property
    def places(self) -> dict[str, Array]:
        """Places of the centre line at the marks [m], MARK/x and MARK/y, shape (N,) each; none without a sub."""
        if not self.subs:
            return {}
        found = self.lateral.marks(self.lateral.read(self.twins)).T
        named = [(mark.name, places) for mark, places in zip(self.scene.string.marks, found, strict=True)]
        return {
            f"{name}/{axis}": part for name, places in named for axis, part in (("x", places.real), ("y", places.imag))
        }

    def _frames(self, number: int, commands: Array) -> Frames | None:
        """Frames of a member over a window, which it has still before it afterwards; None if it cannot be followed."""
        twin, scale = self.twins[number], np.array([self._load(number), 1.0, 1.0])
        before = twin.checkpoint()
        frames, error = twin.fill(twin.record(len(commands)), commands * scale, self.pace.period)
        twin.restore(before)
        if error is not None and not isinstance(error, DrillTwinError):
            raise error
        return frames if error is None else None

    def _load(self, number: int) -> float:
        """Weight on bit of a member over the commanded weight."""
        return float(self.values[number, self.keys.index(LOAD)]) if LOAD in self.keys else 1.0

    def whirls_ahead(self, number: int, commands: Array) -> bool:
        """True for a member that whirls at a time in the windows to come; it is back afterwards.

        Args:
            number: Number of the member.
            commands: Set-points to come, of a number of windows, shape (W, F, 3).
        """
        twin = self.twins[number]
        before = twin.checkpoint()
        try:
            return any(self._advance(number, window)[2] for window in commands)
        except DrillTwinError:
            return True  # a motion that cannot be followed is not calm
        finally:
            twin.restore(before)

    def _advance(self, number: int, commands: Array) -> tuple[Array, Mapping[str, float], bool, Array, Array]:
        """Channels at the frames, (C, F), and what else a `Prediction` has of a member."""
        twin, record, pace = self.twins[number], self._record, self.pace
        commands = commands * np.array([self._load(number), 1.0, 1.0])
        request = Request((), pace.period, pace.frames, 1)
        collectors = Channels(twin, request), Instants(twin, request)
        before = self._reader.start(twin)
        twin.advance_frames(commands, pace.period, record)
        rows, rig = record.frames, RigSeries.of(record.frames)
        for collector in collectors:
            collector.add(rows, rig)
        sensors = {
            "weight_on_bit": float(rig.bit_force[-1]),
            "bit_speed": float(rig.bit_speed[-1]),
            "bit_torque": float(rig.bit_torque[-1]),
            "radius": float(np.hypot(rows.centre[..., 0], rows.centre[..., 1]).max(initial=0.0)),
            "wall_force": float(rows.string[:, 0].max()),
            "bending_stress": float(bending_stress(twin.rod, twin.unknowns[0]).max()),
        }
        variables = {name: value for collector in collectors for name, value in collector.close().items()}
        values = np.array([variables[name].value for name in self.channels]).reshape(-1, pace.frames)
        readings = np.empty((pace.frames, 0, VALUES))
        if record.nodes is not None:
            readings = self._reader.read(before, record.nodes, pace.period)
        whirls = bool(np.any(asynchronous_radius(rows) > self._onset))
        return values, sensors, whirls, readings, rig.bit_speed.copy()

    def _scene(self, number: int) -> Scene:
        """Scene of a member; numbers that do not fit together go towards the middle of the draws until they do."""
        while not takes(self.scene, values := self._overrides(self.values[number])):
            self.normal[number] = self._middle + _INWARD * (self.normal[number] - self._middle)
        return override(self.scene, values | {"numerics.seed": self._seeds[number]})

    def _overrides(self, values: Array) -> dict[str, float]:
        """Values of the free numbers, shape (d,), by full key, without the load's."""
        named = zip(self.keys, values.tolist(), strict=True)
        return {self._full[key]: value for key, value in named if key != LOAD}

    def _check(self) -> None:
        """Refuse what cannot be changed in the middle of a run.

        Raises:
            ArgumentError: A key of string, hole or numerics, a law that changes within its range, or an audit.
        """
        for key in self._full.values():
            if not key.startswith(("effects.", "rig.top_drive.")):
                raise ArgumentError(
                    f"free: expected numbers of effects, of rig.top_drive, or {LOAD}, found {key}, which shapes the "
                    "mesh; `drill-twin fit` finds it from a record"
                )
        ends = [self._overrides(in_ranges(np.full((1, len(self.keys)), end), self.ranges)[0]) for end in (0.0, 1.0)]
        kernels = {kernel_of(override(self.scene, end)) for end in ends if takes(self.scene, end)}
        if len(kernels) > 1 or any(kernel[-1] for kernel in kernels):
            raise ArgumentError(
                "free: expected one law over each range and no numerics.audit, found a law that changes, or an audit; "
                "take a smaller range, or leave the audit out"
            )
