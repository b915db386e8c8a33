# SPDX-License-Identifier: Apache-2.0
"""Advice from an operating map: the place of a set-point, the boundary near it, and the nearest calmer set-point.

Advice is given once the set-points have settled, with one target at a time.
"""

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Mask
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.topic_words import AdviceCode
from drill_twin.whirl import criteria
from drill_twin_studies.maps.operating_map import Margin, OperatingMap
from drill_twin_studies.maps.plane import Node, depth
from drill_twin_studies.maps.regimes import REGIMES, Regime
from drill_twin_studies.maps.runs import RAMP, STAY

MARGIN = 0.05
"""Distance to the boundary that a set-point should have, as a share of the ranges; not measured."""
FROM_REST, DIES = "whirl begins from rest", "an existing whirl dies"
"""Names of the two boundaries."""
NO_BOUNDARY = 1e9
"""Margin in a message where no boundary is met."""


class AdvisedSetPoint(NamedTuple):
    """Advised set-point."""

    weight: float
    """Weight on bit [N]."""
    speed: float
    """Speed [rad/s]."""
    margin: float
    """Distance to the boundary there, as a share of the ranges; infinite without a boundary."""


class Advice(NamedTuple):
    """Advice at one set-point."""

    level: Level
    """OK: calm with margin; WARN: near a boundary, or a whirl that dies; ERROR: leave it."""
    text: str
    """Advice with its reason, as a sentence."""
    regime: Regime | None
    """Regime from rest by the map; None outside its ranges."""
    keeps: bool
    """An existing whirl goes on at the set-point, by the map."""
    boundary: str
    """Name of the boundary to which `margin` is the distance."""
    margin: Margin
    """Distance to this boundary; negative beyond it."""
    target: AdvisedSetPoint | None
    """Set-point to go to, with speed 0 where the rotation must stop; None: stay, or there is none."""


class Adviser:
    """Advice from one map.

    An advised set-point must be calm from rest; while the string whirls, a whirl must die at it, too.
    """

    def __init__(self, found: OperatingMap, margin: float = MARGIN) -> None:
        """Take a map.

        Args:
            found: The map.
            margin: Distance to the boundary that an advised set-point should have, as a share of the ranges.
        """
        self.map = found
        self._margin = margin

    @property
    def patience(self) -> float:
        """Time after which a whirl should have died [s]: the time that the runs of the map had."""
        return (RAMP + STAY) * self.map.duration

    @cached_property
    def _safe(self) -> Mask:
        return np.asarray(self.map.calm & ~self.map.keeps_whirling)

    @cached_property
    def _told(self) -> Mask:
        """Nodes, by speed alone, at which runs had the revolutions that tell a whirl from a shift of the string."""
        speeds = np.linspace(*self.map.plane.speed, self.map.plane.steps + 1)
        return np.asarray(speeds * self.map.duration >= math.tau * criteria.SWEEP_WINDOW)

    def advise(self, weight: float, speed: float, *, whirls: bool, seconds: float = 0.0, stops: bool = False) -> Advice:
        """Advice at a set-point.

        Args:
            weight: Weight on bit [N].
            speed: Speed [rad/s].
            whirls: The string whirls now.
            seconds: Time for which it has whirled at this set-point [s].
            stops: The last advice was to stop the rotation, and the whirl has not ended.
        """
        found, boundary = self.map, DIES if whirls else FROM_REST
        allowed = self._safe if whirls else self.map.calm
        node, inside = found.node(weight, speed), found.contains(weight, speed)
        regime = REGIMES[int(found.regimes[node])] if inside else None
        good = bool(inside and allowed[node])
        late = whirls and good and seconds > self.patience
        margin = found.margin_of(allowed, weight, speed) if inside else Margin(-math.inf, -math.inf, -math.inf)
        target = None
        if not good or late or margin.share < self._margin:
            target = self._target(allowed, weight, speed, above=float(depth(allowed)[node]) if late else 0.0)
        if target is not None and inside and found.node(target.weight, target.speed) == node:
            target = None
        again, slower = None, whirls and (stops or 0.0 <= speed < found.plane.speed.low)
        if slower or (whirls and target is None and (late or not good)):  # a rotation that stops must not be resumed
            again = self._target(found.calm, *found.plane.command((0, 0)), above=math.inf)
            target = None if again is None else AdvisedSetPoint(again.weight, 0.0, math.inf)
        keeps = bool(found.keeps_whirling[node])
        level = Level.ERROR if late or not good else Level.WARN if whirls or target is not None else Level.OK
        text = self._text(regime, margin, target, again, whirls=whirls, good=good, late=late, stops=stops)
        return Advice(level, text, regime, keeps, boundary, margin, target)

    def _target(self, allowed: Mask, weight: float, speed: float, *, above: float = 0.0) -> AdvisedSetPoint | None:
        """Nearest allowed set-point that is farther from the boundary than `above` [steps] and has the wanted margin.

        Where no set-point has the margin, one with the largest margin, which `above` infinite asks for. Speeds so slow
        that no run could tell a whirl are advised only where there are no others.
        """
        if not allowed.any():
            return None
        depths = depth(allowed)
        if (allowed & self._told).any():
            depths = np.where(self._told, depths, 0.0)
        most = float(depths.max())
        if not math.isinf(above) and above >= most:
            return None
        least = min(max(self._margin * self.map.plane.steps + 0.5, above + 0.5), most)
        nodes = np.argwhere(depths >= least)
        place = np.array(self.map.plane.place(weight, speed))
        nearest: Node = tuple(nodes[int(np.argmin(np.hypot(*(nodes - place).T)))].tolist())
        return AdvisedSetPoint(*self.map.plane.command(nearest), (float(depths[nearest]) - 0.5) / self.map.plane.steps)

    def _text(
        self,
        regime: Regime | None,
        margin: Margin,
        target: AdvisedSetPoint | None,
        again: AdvisedSetPoint | None,
        *,
        whirls: bool,
        good: bool,
        late: bool,
        stops: bool,
    ) -> str:
        said = self.map.units.set_point
        low, high = (said(*ends) for ends in zip(self.map.plane.weight, self.map.plane.speed, strict=True))
        if regime is None:
            where = f"outside the map, which has {low} to {high}"
        elif whirls and stops:
            where = "the string still whirls"
        elif whirls and late:
            where = f"the string still whirls after {self.patience:.3g} s, in which a whirl dies here by the map"
        elif whirls:
            where = (
                f"an existing whirl {f'dies here within {self.patience:.3g} s' if good else 'goes on here'} by the map"
            )
        else:
            near = margin.text(self.map.units) if good else ""
            where = f"{regime.value} from rest by the map" + (f", {near} from the boundary" if near else "")
        if again is not None:
            begin = said(again.weight, again.speed)
            return f"{where}, and no better set-point is known: stop the rotation, and begin again at {begin}"
        if target is not None:
            reason = "where a whirl dies" if whirls else "for more margin" if good else "the nearest calm set-point"
            return f"{where}: go to {said(target.weight, target.speed)}, {reason}"
        if good and not late:
            return f"{where}: hold"
        return f"{where}: no calm set-point in its ranges, {low} to {high}"


_ADVICE = JointStateTemplate(
    (
        "advice", "weight_on_bit", "rotation", "regime", "whirls", "existing_whirl", "margin/weight_on_bit",
        "margin/rotation", "margin/share", "target", "target/weight_on_bit", "target/rotation", "target/share",
    ),
    velocity=False, effort=False,
)  # fmt: skip


def encode_advice(stamp: int, advice: Advice | None, weight: float, speed: float, *, whirls: bool) -> bytes:
    """CDR of `/advice/state`, advice at a set-point; all numbers are finite.

    Args:
        stamp: Header stamp [ns].
        advice: The advice; None where there is none.
        weight: Weight on bit [N].
        speed: Speed [rad/s].
        whirls: The string whirls now.
    """
    values = np.zeros(len(_ADVICE.names))
    values[1:5] = weight, speed, -1.0, whirls
    if advice is not None:
        code = {Level.OK: AdviceCode.HOLD, Level.WARN: AdviceCode.NEAR}.get(advice.level, AdviceCode.LEAVE)
        regime = -1 if advice.regime is None else advice.regime.code
        margin, target = advice.margin, advice.target
        values[0], values[3], values[5] = code, regime, advice.keeps
        values[6:9] = margin.weight, margin.speed, margin.share
        if target is not None:
            values[9:] = 1.0, target.weight, target.speed, target.margin
    finite = np.nan_to_num(values, nan=0.0, posinf=NO_BOUNDARY, neginf=-NO_BOUNDARY)
    return _ADVICE.fill(stamp, finite)


SMOOTHING = 0.5
"""Time over which set-points are smoothed [s], as the weight on bit swings with the whirl; not measured."""
MOVED = 0.02
"""Distance beyond which set-points have a new place, as a share of the ranges; not measured."""
SETTLING = 2.0
"""Time for which set-points must have held before there is advice [s]; not measured."""
SPEAKS_AFTER = 10.0
"""Time of a whirl after which there is advice though set-points swing [s]; not measured."""


class Tracker:
    """Set-points smoothed over time, and the advice that stands: one at a time, given once they have settled.

    A target stands until other set-points have settled, so also on the way to it.

    Attributes:
        time: Time of the last set-point [s].
        weight, speed: Weight on bit [N] and speed [rad/s], smoothed.
        waits_for: Reason why there is no advice; empty while there is advice.
    """

    def __init__(self) -> None:
        """Begin without a set-point."""
        self._begin(-math.inf, math.nan, math.nan)

    def _begin(self, time: float, weight: float, speed: float) -> None:
        self.time, self.weight, self.speed = time, weight, speed
        self.waits_for = ""
        self._held = (math.inf, math.inf)  # place near which set-points stay
        self._settling = self._changing = time  # times since which they have stayed there, or not settled
        self._place: tuple[float, float] | None = None  # set-points of the advice
        self._since = time  # of a whirl there
        self._has_target = self._stops = False

    def take(self, time: float, weight: float, speed: float) -> None:
        """Take the weight on bit [N] and the speed [rad/s] at a time [s]; a time before the last begins anew."""
        if self.time == -math.inf or time < self.time:
            self._begin(time, weight, speed)
            return
        share = -math.expm1((self.time - time) / SMOOTHING)
        self.weight += share * (weight - self.weight)
        self.speed += share * (speed - self.speed)
        self.time = time

    def advise(self, adviser: Adviser, *, whirls: bool) -> Advice | None:
        """Advice that stands; None while there is none, as set-points change or the string does not turn."""
        plane, now = adviser.map.plane, (self.weight, self.speed)
        near, place = MOVED * plane.steps, plane.place(*now)
        if math.dist(place, self._held) >= near:
            self._held, self._settling = place, self.time
        # The weight may swing with a whirl so much that it never settles; then it is time to speak.
        if self.time - self._settling >= SETTLING or (whirls and self.time - self._changing >= SPEAKS_AFTER):
            self._changing = self.time
            if self._place is None or math.dist(place, plane.place(*self._place)) >= near:
                self._place, self._since = now, self.time
        elif self._place is not None and not self._has_target:
            self._place = None
        if not whirls:
            self._since = self.time
        self.waits_for = ""
        if not whirls and abs(self.speed) < MOVED * plane.speed.high:
            self.waits_for, self._place = "the string does not turn: no advice", None
        elif self._place is None:
            self.waits_for = f"set-points are changing: advice once they have held for {SETTLING:g} s"
        if self._place is None:
            self._has_target = False
            return None
        seconds, stops = self.time - self._since, self._stops and whirls
        advice = adviser.advise(*self._place, whirls=whirls, seconds=seconds, stops=stops)
        self._has_target = advice.target is not None
        self._stops = whirls and advice.target is not None and advice.target.speed == 0.0
        return advice
