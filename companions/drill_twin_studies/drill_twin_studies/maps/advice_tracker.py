# SPDX-License-Identifier: Apache-2.0
"""Advice in time: given once set-points have settled, and one target at a time."""

from __future__ import annotations

import math

from drill_twin_studies.maps.advice import Advice, Adviser

SMOOTHING = 0.5
"""Time over which set-points are smoothed [s]: the weight on bit swings with the whirl."""
MOVED = 0.02
"""Distance beyond which set-points have a new place, as a share of the ranges."""
SETTLING = 2.0
"""Time for which set-points must have held before there is advice [s]."""
LONGEST = 10.0
"""Time of a whirl after which there is advice though they swing [s]."""


class Tracker:
    """Set-points smoothed over time, and the advice that stands: one at a time, given once they have settled.

    A target stands until other set-points have settled, so also on the way to it.
    """

    def __init__(self) -> None:
        """Begin without a set-point."""
        self.time = -math.inf
        """Time of the last set-point [s]."""
        self.weight = self.speed = math.nan
        """Weight on bit [N] and speed [rad/s], smoothed."""
        self._begin(-math.inf, math.nan, math.nan)

    def _begin(self, time: float, weight: float, speed: float) -> None:
        self.time, self.weight, self.speed = time, weight, speed
        self.waits_for = ""
        """Reason why there is no advice; empty where there is."""
        self._held = (math.inf, math.inf)  # place near which they stay
        self._settling = self._changing = time  # since when they have stayed there, or not settled
        self._place: tuple[float, float] | None = None  # set-points of the advice
        self._since = time  # of a whirl there
        self._has_target = self._stops = False

    def take(self, time: float, weight: float, speed: float) -> None:
        """Take the weight on bit [N] and the speed [rad/s] at a time [s]; one before the last begins anew."""
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
        if self.time - self._settling >= SETTLING or (whirls and self.time - self._changing >= LONGEST):
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
