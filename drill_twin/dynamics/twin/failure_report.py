# SPDX-License-Identifier: Apache-2.0
"""Error message of a stopped run: violation, effect that caused it, remedy.

The effect is found by evaluating each separately, at every element. That runs once, when a run is stopped, so nothing
is compiled for it: the functions of effects run as Python.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.compile.jit import as_python
from drill_twin.core.errors import StoppedError
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.step_guard import REMEDIES, Violation
from drill_twin.physics.effects import Effect, effect_module
from drill_twin.physics.model import Point, Rod, Strain, element_unknowns, strain_at
from drill_twin.physics.model.section import RESULTANTS


class EvaluationPoint(NamedTuple):
    """State and time at which effects are evaluated."""

    u: Array  # node rows (r, r', psi), shape (n + 1, 7)
    v: Array  # their velocities
    time: float  # [s]
    step: float  # [s]
    command: Array  # weight on bit [N], rotation [rad/s]


def diagnose(
    parameters: Any, rod: Rod, effects: Sequence[Effect], moments: Sequence[EvaluationPoint], node: int | None = None
) -> tuple[str, str]:
    """The effect that most likely caused a failure, and a sentence about it; two empty texts where none acts.

    The first whose load is not a number, else the strongest by force [N], a couple divided by the string's radius and a
    bending moment by the length of an element.

    Args:
        parameters: Of all effects, as the kernel takes them.
        rod: The string.
        effects: The effects, as the kernel calls them.
        moments: States and times to evaluate at.
        node: The node at which to evaluate; all, where it is None.
    """
    strongest, size, place, last = "", 0.0, 0.0, rod.length.size - 1
    elements = range(last + 1) if node is None else range(max(node - 1, 0), min(node, last) + 1)
    with np.errstate(all="ignore"):
        for effect in effects:
            for moment in moments:
                loads = np.zeros(last + 1)
                loads[elements] = [_load_on_element(parameters, rod, effect, e, moment) for e in elements]
                loads[[0, -1]] += _load_at_ends(parameters, rod, effect, moment) * [0 in elements, last in elements]
                if not np.isfinite(loads).all():
                    place = float(rod.arc[int(np.argmin(np.isfinite(loads)))])
                    return effect.key, f"{effect.key} gives no number {place:.3g} m from the bit"
                if loads.max() > size:
                    strongest, size, place = effect.key, float(loads.max()), float(rod.arc[int(loads.argmax())])
    return strongest, f"strongest: {strongest} ({size:.3g} N {place:.3g} m from the bit)" if strongest else ""


def _call(effect: Effect, hook: str, *arguments: Any) -> None:
    """Call an effect's function for a hook, if it has one, as Python."""
    if function := effect.function(hook):
        as_python(getattr(effect_module(effect.key), function))(*arguments)


def _load_on_element(parameters: Any, rod: Rod, effect: Effect, e: int, at: EvaluationPoint) -> float:
    """Size of an effect's load on an element [N]."""
    total = 0.0
    for p in range(2):
        strain, here = _sample(rod, e, p, at)
        load, stiff, out = np.zeros(4), np.zeros((4, 4)), np.zeros(RESULTANTS)
        _call(effect, "distributed_load", parameters, rod, here, 0.5 * at.step, load, stiff)
        _call(effect, "section_stress", parameters, rod, strain, 0.5 * at.step, out)
        share = 0.5 * rod.length[e]
        total += share * float(np.linalg.norm(load[:3]) + abs(load[3]) / rod.outer_radius[e])
        total += float(np.linalg.norm(out[:4])) / rod.length[e]
    return total


def _load_at_ends(parameters: Any, rod: Rod, effect: Effect, at: EvaluationPoint) -> Array:
    """Size of an effect's loads at the bit and at the top [N], shape (2,)."""
    ends = np.zeros((2, 7, 8))
    # in the frame of the hole at the top, which is accurate enough to compare effects
    _call(effect, "end_load", parameters, rod, at.command, at.time, 0.5 * at.step, at.u, at.v, at.v, ends)
    return np.asarray(np.linalg.norm(ends[:, :3, 7], axis=1) + np.abs(ends[:, 6, 7]) / rod.outer_radius[[0, -1]])


def _sample(rod: Rod, e: int, p: int, at: EvaluationPoint) -> tuple[Strain, Point]:
    """Arguments of the effects at a Gauss point."""
    u, v = element_unknowns(at.u[e : e + 2])[0], element_unknowns(at.v[e : e + 2])[0]
    w = rod.shape[e, p]
    l0, l1 = rod.spin_shape[p]
    psi, rate = l0 * at.u[e, 6] + l1 * at.u[e + 1, 6], l0 * at.v[e, 6] + l1 * at.v[e + 1, 6]
    turned = (at.u[e + 1, 6] - at.u[e, 6]) / rod.length[e], (at.v[e + 1, 6] - at.v[e, 6]) / rod.length[e]
    r, dr = w[0] @ u, w[0] @ v
    a, b, da, db = (tuple(w[order] @ rows) for rows in (u, v) for order in (1, 2))
    cos, sin = float(np.cos(psi)), float(np.sin(psi))
    s = as_python(strain_at)(e, 2 * e + p, a, b, da, db, psi, cos, sin, turned[0], rate, turned[1])
    here = Point(
        e, 2 * e + p, at.time, r[0], r[1], r[2], dr[0], dr[1], dr[2], 0.0, 0.0, 0.0, s.tx, s.ty, s.tz, psi, rate, 0.0,
        cos, sin, True, 0.0,
    )  # fmt: skip
    return s, here


def failure_report(
    dynamics: Dynamics, found: Violation, suspect: Array, target: Array, seconds: float, step: float
) -> StoppedError:
    """Make the error about a frame that failed in all retries.

    Args:
        dynamics: Dynamics at the last good frame.
        found: Last violation.
        suspect: Node rows u and v with this violation, shape (2, n + 1, 7).
        target: Weight on bit [N] and rotation [rad/s] at the end of the frame.
        seconds: Length of the frame [s].
        step: Last time step [s].
    """
    states = [dynamics.unknowns, (suspect[0], suspect[1])] if np.isfinite(suspect).all() else [dynamics.unknowns]
    moments = [
        EvaluationPoint(u, v, time, step, command)
        for u, v in states
        for time, command in ((dynamics.time + 0.5 * step, dynamics.command), (dynamics.time + seconds, target))
    ]
    kept = dynamics.memory_block.copy()  # evaluation may change the state of an effect
    late = found.kind in {"slow", "long"}
    place = found.node if late else None
    effect, doing = diagnose(dynamics.parameters, dynamics.rod, dynamics.effects, moments, place)
    if found.kind == "long":  # no place and no effect is to blame
        effect, doing = "", ""
    dynamics.memory_block[:] = kept
    kick = dynamics.scene.effects.lateral_kick
    kicked = kick is not None and kick.offset != 0.0 and dynamics.time == 0.0 and found.kind == "penetration"
    kind = "finite" if "no number" in doing else "kick" if kicked else found.kind
    remedy = REMEDIES["fold in a hole" if kind == "fold" and dynamics.wall is not None else kind]
    tried = f", however often it was taken back and the step halved, down to {step:.2g} s"
    return StoppedError(
        f"the motion could not be followed past t = {dynamics.time:.6g} s{'' if late else tried}: {found.text}, under "
        f"{target[0]:.6g} N and "
        f"{target[1]:.6g} rad/s{f'; {doing}' if doing else ''}. "
        f"{remedy.capitalize()}",
        dynamics.time, found.kind, found.node, effect,
    )  # fmt: skip
