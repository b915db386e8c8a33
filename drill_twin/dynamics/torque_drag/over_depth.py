# SPDX-License-Identifier: Apache-2.0
"""Hookload and torque of the soft string over the depth of its bit; factors of friction fitted to measured loads."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, nearest, shortened
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.torque_drag.along_string import hole_and_string
from drill_twin.dynamics.torque_drag.sliding_balance import steady
from drill_twin.dynamics.torque_drag.soft_string import Operation, operations, soft_string
from drill_twin.physics.effects.wall_friction import FrictionInterval, WallFriction
from drill_twin.scene import Scene

OWN = 1e-12
"""Difference from the coefficient of the law from which an interval has its own."""
LEAST_LOAD, LARGEST = 1e-9, 5.0
"""Least measured hookload [N], as a rig that holds a string reads more than 0; largest coefficient of friction [-], as
for `drill_twin scene new --friction`."""
PLACES = 60
"""Most depths at which a fit computes loads; between them loads are linear in depth. Chosen, not measured."""
CONFIDENT, APART, STEP = 0.95, 0.1, 1e-4
"""Probability of the intervals of a fit; the largest error of factors that count as known [-]; the step of a factor in
derivatives, and the distance from its bound within which a factor is put on it [-]; chosen."""
FELT = 1e-4
"""Change of the loads by a factor of 1, over the largest load, below which no load depends on the factor; chosen."""
BINS, LEAST_IN_BIN = 5, 3
"""Most ranges of depth of a trend, and the least number of points in a range; chosen."""


class Trend(NamedTuple):
    """Factor that the points in a range of depth have, the other factor as fitted to all points."""

    top: float
    """Shallowest point [m]."""
    bottom: float
    """Deepest point [m]."""
    points: int
    part: str
    """Part of the hole with the factor, as in `FrictionFit.parts`."""
    friction: float
    error: float


class FrictionFit(NamedTuple):
    """Factors of friction in casing and open hole, fitted together to p measured loads by least squares.

    Errors are half-widths of intervals of the probability `CONFIDENT`, by the scatter of the points and Student's t:
    of errors of a load that are independent; infinite without a point more than factors.
    """

    parts: tuple[str, ...]
    """`cased` and `open`, either of them, or `both`, one factor for all of the hole; none if no load depends on any."""
    friction: Array
    """Shape (parts,); 0 or `LARGEST` at its bound."""
    error: Array
    """Shape (parts,); of the linear problem without bounds; infinite where the points leave a factor open."""
    apart: Array
    """Errors of cased and open where they cannot be told apart, shape (2,); else shape (0,)."""
    residual: Array
    """Measured less fitted loads [N] or [N m], shape (p,)."""
    beyond: int
    """Points outside of the curves; the fit counts them like all others."""
    trend: tuple[Trend, ...]
    """Ranges of depth whose error is at most `APART`, from the top down."""


@dataclass(frozen=True, eq=False)
class OverDepth:
    """Loads at the surface; o operations, f coefficients, d depths."""

    scene: Scene
    equations: EquationsOfMotion
    """Of the steady scene."""
    depth: Array
    """Measured depth of the bit [m], shape (d,)."""
    friction: Array
    """Coefficients, shape (f,)."""
    operations: tuple[Operation, ...]
    """Trip out, trip in, off bottom."""
    hookload: Array
    """[N], shape (o, f, d); NaN where the string locks."""
    torque: Array
    """While it rotates off bottom [N m], shape (f, d)."""

    def curves(self, load: str) -> tuple[Array, Operation]:
        """Loads for each coefficient, shape (f, d), and their operation; `load` as in `fit`."""
        names = [operation.name for operation in self.operations]
        if load not in (known := (*names, "torque")):
            raise ArgumentError(f'expected a load of {", ".join(known)}, found "{load}"{nearest(str(load), known)}')
        k = names.index("off bottom" if load == "torque" else load)
        return (self.torque if load == "torque" else self.hookload[k]), self.operations[k]

    @property
    def casing(self) -> list[FrictionInterval]:
        """Cased parts: intervals of friction; without any, the intervals of the hole that follow from the top."""
        law, found = getattr(self.scene.effects, "wall_friction", None), list[FrictionInterval]()
        if law is not None and law.intervals:
            return list(law.intervals)
        for part in self.scene.hole.intervals:
            if part.top == (found[-1].bottom if found else 0.0):
                found.append(FrictionInterval(top=part.top, bottom=part.bottom, coefficient=0.0))
        return found

    def fit(self, load: str, depth: Array, measured: Array) -> FrictionFit:
        """Factors of friction in casing and open hole whose loads at the surface are nearest to measured loads.

        Args:
            load: Name of an operation, whose hookload is measured [N], or `torque`, off bottom [N m].
            depth: Measured depths of the bit [m], shape (p,).
            measured: Measured loads, shape (p,).

        Raises:
            ArgumentError: No such load, values that are no finite numbers, a depth outside of the string, a hookload
                of 0 or less, or not as many loads as depths.
        """
        depth = _numbers("depths [m]", depth, 0.0, self.scene.length * (1.0 + 1e-6))
        measured = _numbers(
            f"measured loads, {load}", measured, -math.inf if load == "torque" else LEAST_LOAD, math.inf
        )
        if depth.size != measured.size:
            raise ArgumentError(f"expected a load a depth, found {measured.size} loads and {depth.size} depths")
        of, start, step, known = _Loads(self, load, depth), float(self.friction.mean()), APART, np.zeros(0)
        rows = np.nan_to_num([np.interp(depth, self.depth, row) for row in self.curves(load)[0]], nan=-math.inf)
        beyond = int(np.sum((measured < rows.min(axis=0)) | (measured > rows.max(axis=0))))
        while not np.isfinite(of(np.full(2, start + step))).all():  # a measured load is of a string that slides
            start, step = 0.5 * start, 0.5 * step
        base = of(np.full(2, start))
        slopes = np.column_stack([of(start + step * part) - base for part in np.eye(2)]) / step
        felt = np.abs(slopes).max(axis=0) > FELT * np.abs(measured).max()
        if not felt.any():
            return FrictionFit((), known, known, known, measured - base, beyond, ())
        parts = tuple(part for part, is_felt in zip(("cased", "open"), felt, strict=True) if is_felt)
        best, error, scatter = _least(of, np.eye(2) if felt.all() else np.ones((2, 1)), measured, start)
        if felt.all() and not error.max() <= APART:
            parts, known = ("both",), error
            best, error, scatter = _least(of, np.ones((2, 1)), measured, start)
        return FrictionFit(parts, best.x, error, known, -best.fun, beyond, tuple(_trend(parts, best, scatter, depth)))


class _Loads:
    """Loads at measured depths, shape (p,), as a function of the factors in casing and open hole."""

    def __init__(self, found: OverDepth, load: str, depth: Array) -> None:
        self.operation, self.is_torque, self.depth = found.curves(load)[1], load == "torque", depth
        casing = tuple(part.model_copy(update={"coefficient": 0.0}) for part in found.casing)
        shares = WallFriction(coefficient=1.0, intervals=casing)
        scene, model = found.equations.scene, found.equations.model
        scene = scene.model_copy(update={"effects": scene.effects.model_copy(update={"wall_friction": shares})})
        places = np.unique(depth)
        self.places = places if places.size <= PLACES else np.linspace(places[0], places[-1], PLACES)
        self.strings = [hole_and_string(scene, model, place) for place in self.places.tolist()]
        """Strings whose friction is the share of an element in open hole."""

    def __call__(self, friction: Array) -> Array:
        found = []
        for string in self.strings:
            mixed = friction[0] + (friction[1] - friction[0]) * string.friction
            soft = soft_string(string._replace(friction=mixed), self.operation)
            found.append(soft.surface_torque if self.is_torque else soft.hookload)
        return np.interp(self.depth, self.places, found)


def _least(of: _Loads, parts: Array, measured: Array, start: float) -> tuple[Any, Array, float]:
    """Least squares, errors of the factors and of a load; `parts` (2, k) makes cased and open of k factors."""
    factors, lost = parts.shape[1], measured.size - parts.shape[1]
    best = least_squares(
        lambda own: of(parts @ own) - measured, np.full(factors, start), bounds=(0.0, LARGEST),
        jac=lambda own: np.array([of(parts @ own) - of(parts @ (own - h)) for h in STEP * np.eye(factors)]).T / STEP,
    )  # fmt: skip
    best.x = np.where(best.x < STEP, 0.0, np.where(best.x > LARGEST - STEP, LARGEST, best.x))
    if lost < 1 or np.linalg.matrix_rank(best.jac) < factors:
        return best, np.full(factors, math.inf), math.inf
    scatter = float(student.ppf(0.5 + 0.5 * CONFIDENT, lost)) * math.sqrt(2.0 * best.cost / lost)
    return best, scatter * np.sqrt(np.diag(np.linalg.pinv(best.jac.T @ best.jac))), scatter


def _trend(parts: tuple[str, ...], best: Any, scatter: float, depth: Array) -> Iterator[Trend]:
    """Factors by range of depth, to first order: of the open hole where it is known there."""
    count = min(BINS, depth.size // LEAST_IN_BIN)
    for rows in np.array_split(np.argsort(depth, kind="stable"), count) if count > 1 else ():
        sizes = np.linalg.norm(best.jac[rows], axis=0)
        for k in reversed(range(len(parts))):
            if scatter <= APART * sizes[k]:
                friction = float(best.x[k] - best.jac[rows, k] @ best.fun[rows] / sizes[k] ** 2)
                top, bottom = depth[rows[[0, -1]]].tolist()
                yield Trend(top, bottom, rows.size, parts[k], friction, float(scatter / sizes[k]))
                break


def _numbers(name: str, values: Any, low: float, high: float) -> Array:
    """Numbers as an array (n,).

    Raises:
        ArgumentError: They are none, or not all finite and from `low` to `high`.
    """
    try:
        found = np.asarray(values, float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    wrong = ~(np.isfinite(found) & (found >= low) & (found <= high))
    if found.ndim != 1 or not found.size or wrong.any():
        told = f"{found[wrong][0]:g}" if found.ndim == 1 and wrong.any() else shortened(repr(values), 80)
        raise ArgumentError(f"{name}: expected finite numbers from {low:g} to {high:g}, found {told}")
    return found


def over_depth(scene: Scene, friction: Sequence[float], depths: int) -> OverDepth:
    """Loads of the lower part of a string whose bit is on its way down.

    Args:
        scene: The scene; elements given or `auto`.
        friction: Coefficients on the wall; an interval with a coefficient of its own, such as a casing, keeps its own.
        depths: Number of depths, evenly spaced down to the depth of the scene.

    Raises:
        ArgumentError: Coefficients that are not finite numbers from 0 to `LARGEST`, or no depth.
    """
    coefficients = _numbers("friction", friction, 0.0, LARGEST)
    _numbers("depths", [depths], 1.0, math.inf)
    equations = EquationsOfMotion(steady(scene))
    law = getattr(scene.effects, "wall_friction", None)
    depth = np.linspace(0.0, scene.length, depths + 1)[1:]
    wanted = tuple(operations(0.0, 1.0))
    hookload = np.empty((len(wanted), coefficients.size, depths))
    torque = np.empty((coefficients.size, depths))
    for d, bit in enumerate(depth.tolist()):
        string = hole_and_string(equations.scene, equations.model, bit)
        own = np.zeros(string.length.size, bool) if law is None else abs(string.friction - law.coefficient) > OWN
        for f, coefficient in enumerate(coefficients.tolist()):
            rubbing = string._replace(friction=np.where(own, string.friction, coefficient))
            for o, operation in enumerate(wanted):
                loads = soft_string(rubbing, operation)
                hookload[o, f, d] = loads.hookload
                if operation.rotation:
                    torque[f, d] = loads.surface_torque
    return OverDepth(scene, equations, depth, coefficients, wanted, hookload, torque)
