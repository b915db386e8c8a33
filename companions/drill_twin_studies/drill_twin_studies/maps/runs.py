# SPDX-License-Identifier: Apache-2.0
"""Runs of a map: members of an ensemble at nodes of the plane, and what is kept of each."""

import math
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import NonNegativeInt

from drill_twin.core.arrays import number_or_nan
from drill_twin.core.severity import Grade, worst
from drill_twin.core.units.dimension import GRAVITY
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.runs.ensemble import Executor, expand
from drill_twin.runs.ensemble.outputs import Request
from drill_twin.runs.ensemble.run import MemberRun
from drill_twin.scene import Scene
from drill_twin.scene.schema import number_at
from drill_twin.whirl import criteria
from drill_twin.whirl.criteria import BitMotion
from drill_twin.whirl.motion.stick_slip_index import MODERATE, TIME_BASE
from drill_twin_studies.maps.plane import Node, Plane
from drill_twin_studies.maps.regimes import OFF_AXIS, Regime, TorsionalSpeeds, regime_of
from drill_twin_studies.maps.rolling import RollingFriction
from drill_twin_studies.maps.trend import Trend

FRICTION = "effects.wall_friction.coefficient"
WEIGHT, SPEED = "rig.weight_on_bit", "rig.rotation"
HOLD, RAMP, STAY = 1.0, 0.25, 1.25
"""Times over the duration of a run from rest: at a whirling set-point, on the way from it to the node, and at the node;
not measured."""
ORBIT = 120
"""Samples of the last orbit that are kept; not measured."""
ORBIT_RATE = 25.0
"""Largest rate of the samples of an orbit [Hz]; not measured."""
GRADED = {"lateral_rms": "acceleration", "lateral_peak": "acceleration", "bending_stress": "stress", "stick_slip": ""}
"""Quantities of `core.severity.Bounds` that grade a run, and what they measure."""
OUTPUTS = ("findings", "last_half", "settling", "marks")
FINER = 64
"""Places of a check in each step of the lattice."""


class Key(NamedTuple):
    """One run of a map."""

    i: int
    j: int
    draw: int = 0
    """0: the scene as it is; others: other seeds and uncertain numbers."""
    origin: Node | None = None
    """Whirling node that the run comes from; None: from rest."""
    finer: int = 1
    """1 for i and j in steps of the lattice; `FINER` for a check, a run of the whole time asked: i and j in so many
    parts of a step."""

    @property
    def node(self) -> Node:
        """Node of the run; of a check, the nearest node below."""
        return self.i // self.finer, self.j // self.finer

    @property
    def place(self) -> tuple[float, float]:
        """Place of the run on the lattice, in steps."""
        return self.i / self.finer, self.j / self.finer

    @property
    def searches(self) -> bool:
        """True for a run from rest at a node."""
        return self.origin is None and self.finer == 1

    def length(self, duration: float, asked: float) -> float:
        """Simulated time [s] of the run, from the time of a run from rest and the time asked."""
        return asked if self.finer > 1 else duration if self.origin is None else (HOLD + RAMP + STAY) * duration


@dataclass(frozen=True)
class RunRecord:
    """Findings and severity of one run; NaN where there is none."""

    regime: Regime
    onset_s: float = math.nan
    """Onset of whirl [s]."""
    whirl_hz: float = math.nan
    """Whirl frequency, positive = forward [Hz]."""
    ratio: float = math.nan
    """Whirl ratio."""
    bit: str = ""
    """Motion of the bit at the end."""
    radius: float = math.nan
    """Largest radius of a mark over its clearance, last half of the run."""
    wall_force: float = math.nan
    """Largest wall force of a node [N], last half of the run."""
    torque_swing: float = math.nan
    """Largest less smallest torque of the top drive [N m], last half of the run."""
    bending_stress: float = math.nan
    """Largest bending stress at the end of the run [Pa]: half of the range of a fibre that turns in a bent string."""
    lateral_rms_g: float = math.nan
    lateral_peak_g: float = math.nan
    """Lateral acceleration of the centre line at the mark with the largest, last half of the run [g]."""
    severity: Grade | None = None
    """Grade by the bounds of the scene, of acceleration, bending stress and stick-slip index; None: not known."""
    decided_by: str = ""
    """Quantity of `core.severity.Bounds` that decides it."""
    unsettled: str = ""
    """Reason why a longer run may end otherwise; empty: none is known."""
    growth: float = math.nan
    """Growth of the lateral motion that neither rests nor turns with the string, at the end [1/s]."""
    bit_index: float = math.nan
    top_index: float = math.nan
    """Stick-slip index of bit and top drive at the end."""
    failure: str = ""
    """Reason why the run could not be followed; empty if it was."""
    orbit: tuple[tuple[int, int], ...] = ()
    """Last orbit of the mark with the largest radius, in thousandths of its clearance."""

    @property
    def whirls(self) -> bool:
        """The string whirls at the end, otherwise than by creeping that is calm."""
        return self.regime.whirls or (self.regime is Regime.CREEPING and not self.calm)

    @property
    def calm(self) -> bool:
        """No whirl but creeping, settled, and at most low; with an unknown severity smooth motion alone is."""
        if self.severity is None or self.regime in {Regime.FAILED, Regime.UNSETTLED}:
            return self.regime is Regime.SMOOTH and not self.unsettled
        return self.severity < Grade.MEDIUM and not (self.regime.whirls or self.unsettled)

    def to_dict(self) -> dict[str, Any]:
        """Plain types; numbers that are not known left out."""
        plain = {**asdict(self), "regime": self.regime.value, "orbit": [list(point) for point in self.orbit]}
        return {
            name: value
            for name, value in plain.items()
            if value not in ("", [], None) and not (isinstance(value, float) and not math.isfinite(value))
        }


Place = tuple[NonNegativeInt, NonNegativeInt]
"""Place on a lattice in a file."""


@dataclass(frozen=True, kw_only=True)
class RunOfFile(RunRecord):
    """A run in `map.json`: its record and its `Key`."""

    node: Place
    draw: NonNegativeInt
    origin: Place | None
    finer: Literal[1, 64]

    @property
    def key(self) -> Key:
        """Key of the run."""
        return Key(*self.node, self.draw, self.origin, self.finer)

    @property
    def record(self) -> RunRecord:
        """The record alone."""
        return RunRecord(*(getattr(self, field.name) for field in fields(RunRecord)))


@dataclass(frozen=True)
class Runner:
    """Runs members of one scene.

    Attributes:
        scene: The base scene.
        plane: Plane of the map.
        duration: Simulated time of a run from rest [s].
        asked: Time for which a calm set-point must stay calm [s]: what grows is extrapolated to it.
        draws: Values of seed and uncertain numbers by key, one mapping a draw; empty without draws.
        executor: Place where the members are run.
    """

    scene: Scene
    plane: Plane
    duration: float
    asked: float
    draws: Sequence[Mapping[str, float | str]]
    executor: Executor

    def run(self, keys: Sequence[Key]) -> Generator[tuple[Key, RunRecord]]:
        """Make runs, and yield each as it ends; runs of one length together, runs from rest first."""
        for kind in sorted({(key.finer, key.origin is not None) for key in keys}):
            group = [key for key in keys if (key.finer, key.origin is not None) == kind]
            length = group[0].length(self.duration, self.asked)
            rows = [values_of(self.plane, self.duration, key, self.draws) for key in group]
            members = expand(self.scene, {name: [row[name] for row in rows] for name in rows[0]}, zipped=True)
            with closing(self.executor.run(members, self._request(length))) as ended:
                for number, run in ended:
                    yield group[number], self._record(run, group[number])

    def _request(self, duration: float) -> Request:
        period = self.scene.numerics.frame_period_ns
        frames = max(1, math.ceil(duration * NANOSECONDS / period - 0.5))
        every = max(1, round(self.scene.numerics.frame_rate / ORBIT_RATE))
        return Request(OUTPUTS, seconds(period), frames, every)

    def _record(self, run: MemberRun, key: Key) -> RunRecord:
        if run.failure or not run.values:
            return RunRecord(Regime.FAILED, failure=run.failure or "no frame was computed")
        values = {name: variable.value for name, variable in run.values.items()}
        clearance = np.array([mark.clearance for mark in self.scene.mark_table])
        shares = values["radius_late"] / clearance
        summary, widest = values["summary"], int(np.argmax(shares))
        orbit = np.rint(values["centre"][-ORBIT:, widest] / clearance[widest] * 1000.0)
        onset, hz, ratio = (
            number_or_nan(found) for found in (summary.onset_s, summary.mean_frequency_hz, summary.mean_ratio)
        )
        length, index = key.length(self.duration, self.asked), values["stick_slip_index"]
        torsion = TorsionalSpeeds(float(index[1].max()), *values["mean_speed"].tolist())
        lateral = Trend(values["lateral_rest"][0] / clearance, values["lateral_rest"][1] / clearance, length / 4.0)
        twist = Trend(index[0], index[1], min(float(TIME_BASE), length / 4.0))
        before, now = values["lateral_rms"]
        shaken, ahead = Trend(before, now, length / 4.0), max(self.asked - length, 0.0)
        bounds = self.scene.severity_bounds
        rms, peak = float(np.hypot(before, now).max()) / math.sqrt(2.0), float(values["lateral_peak"].max())
        stress, decays = float(values["bending_stress_end"]), summary.bit is BitMotion.DECAYING
        graded = zip(GRADED, (rms, peak, stress, math.nan if decays else float(index[1, 0])), [""] * 4, strict=True)
        severity = worst(graded, bounds)
        reasons = {
            "bit and top drive turn at different speeds": torsion.winds,
            "its lateral motion grows": lateral.reaches(criteria.ONSET_RADIUS, ahead),
            "its torsional motion grows": not decays and twist.reaches(MODERATE, ahead),
            "a whirl began and ended": key.origin is None and math.isfinite(onset),
        }
        regime = regime_of(summary, shares, torsion, vertical=self._rolling.vertical, grows=any(reasons.values()))
        force, rolls = float(values["wall_force_late"]), self._rolling.ratio(widest)
        slow = abs(ratio) < criteria.ROLLING_SLIP * min(1.0, rolls)
        if regime in {Regime.FORWARD, Regime.BACKWARD} and force > 0.0 and slow:  # the wall is touched between marks
            regime = Regime.CREEPING
        if regime.whirls or regime is Regime.CREEPING:
            reasons.popitem()
        speed, draw = self.plane.command(key.place)[1], self.draws[key.draw] if self.draws else {}
        friction = float(draw.get(FRICTION, number_at(self.scene, FRICTION) or 0.0))
        reasons |= {
            "its acceleration grows": regime in OFF_AXIS and shaken.reaches(bounds.lateral_rms[1], ahead),
            "it may come to roll": regime in OFF_AXIS and min(ahead, force, friction) > 0.0
            and friction >= self._rolling.needed(widest, speed),
        }  # fmt: skip
        return RunRecord(
            regime, onset, hz, ratio, summary.bit.value, float(shares.max()),
            force, float(values["torque_swing_late"]), stress, rms / GRAVITY, peak / GRAVITY,
            severity and severity.grade, severity.quantity if severity else "",
            ", ".join(reason for reason, holds in reasons.items() if holds),
            lateral.rate, float(index[1, 0]), float(index[1, 1]),
            orbit=tuple((int(x), int(y)) for x, y in orbit[np.isfinite(orbit).all(axis=1)]),
        )  # fmt: skip

    @cached_property
    def _rolling(self) -> RollingFriction:
        return RollingFriction(self.scene)


def values_of(
    plane: Plane, duration: float, key: Key, draws: Sequence[Mapping[str, float | str]]
) -> dict[str, float | str]:
    """Values in which a run differs from the base scene, in SI."""
    values: dict[str, float | str] = {}
    for axis, (name, value) in enumerate(zip((WEIGHT, SPEED), plane.command(key.place), strict=True)):
        values[f"{name}.value"] = value
        if key.origin is not None:
            values |= {
                f"{name}.shape": "ramp", f"{name}.initial": plane.command(key.origin)[axis],
                f"{name}.start": HOLD * duration, f"{name}.duration": RAMP * duration,
            }  # fmt: skip
    return values | dict(draws[key.draw] if draws else {})
