# SPDX-License-Identifier: Apache-2.0
"""Depth from which a string moves laterally too; above it the string follows the hole (`numerics.lateral_from`)."""

import math
from itertools import takewhile
from operator import itemgetter

import numpy as np

from drill_twin.core.arrays import Array, Mask
from drill_twin.dynamics.discretisation.discretise import (
    axial_weight,
    axis_at,
    discretise,
    kept,
    sections_of,
    tubes_of,
    untwisted,
)
from drill_twin.dynamics.solver.joined.linear_solver import Workspace, make_workspace
from drill_twin.physics.effects.gravity import line_weight
from drill_twin.physics.model import SPIN, Axis, DiscreteModel, Rod, Tube, build_rod, part_of, tube_constants
from drill_twin.scene import Scene
from drill_twin.scene.check import needs_lateral
from drill_twin.scene.set_points import Command, extremes

STIFFER = 3.0
"""Bending stiffness of a section of the assembly over the stiffness of the most flexible pipe of the string."""
WAVES = 3.0
"""Length above assembly and buckled pipe, in bending waves of pipe without tension at the frequency of rotation."""
LEAST_WAVE, LONGEST_WAVE = 10.0, 100.0
"""Bounds of such a bending wave [m]."""
LONGEST_ABOVE = 30.0
"""Longest element above the joint [m]: a stand, a sixth of the torsional wave of 17 Hz."""
WHIRLS, OVER = 0.5, 2.0
"""Sideways speed at the joint over the speed of the surface there, from which the string is said to whirl, rms over a
time [s]: calm wells of 1,000 m had 0.04 to 0.32, and wells whose hookload or torque was off 0.57 to 1.3. Frames count
once the joint has turned round: a string that starts on the axis falls to the low side before."""
SAMPLES = 400
"""Elements of the mesh by length on which compression and resolution are evaluated."""


def joint_of(scene: Scene) -> float | None:
    """Distance from the bit up to which the string moves laterally too [m]; None: the whole string does.

    With `auto` that is `WAVES` bending waves above the assembly, the sections from the bit up that are stiffer than
    pipe, and above all pipe whose compression may buckle it; none where the scene needs lateral motion further up.

    Raises:
        TableError: `auto` is to be chosen for a record that cannot be used.
    """
    depth = scene.numerics.lateral_from
    if depth == 0.0 or (depth == "auto" and needs_lateral(scene)):
        return None
    return _chosen_joint(scene, extremes(scene)) if depth == "auto" else scene.length - depth


@kept
def _chosen_joint(scene: Scene, most: Command) -> float | None:
    """The joint of `auto` under the largest set-points, which a record may hold."""
    pipe, assembly = min((tube_constants(tube) for tube in sections_of(scene)), key=itemgetter(1)), collars_of(scene)
    speed = max(abs(most.rotation), 1e-9)
    wave = math.tau * (pipe[1] / (pipe[3] * speed**2)) ** 0.25
    joint = max(assembly, buckled_up_to(scene)) + WAVES * min(max(wave, LEAST_WAVE), LONGEST_WAVE)
    return joint if joint < scene.length - LONGEST_ABOVE else None


def collars_of(scene: Scene) -> float:
    """Length of the sections from the bit up that are `STIFFER` than the most flexible pipe [m]; 0: none."""
    sections = sections_of(scene)
    bending = [tube_constants(tube)[1] for tube in sections]
    stiff = takewhile(lambda pair: pair[1] >= STIFFER * min(bending), zip(sections, bending, strict=True))
    return math.fsum(tube.length for tube, _ in stiff)


def buckled_up_to(scene: Scene) -> float:
    """Distance from the bit of the highest place whose compression passes the sinusoidal buckling load [m]; 0: none.

    2 sqrt(EI w / r) of pipe that its weight across the hole presses to the wall (Dawson and Paslay 1984), at least
    1.94 (EI q^2)^(1/3) of pipe that hangs (Lubinski 1950); without friction, rotating on bottom.
    """
    rod = build_rod(tubes_of(scene), SAMPLES)
    model, gravity = discretise(scene, rod), scene.effects.gravity
    weight = axial_weight(scene, model)
    own = np.zeros(rod.length.size) if gravity is None else np.abs(line_weight(gravity, model))
    across = np.sqrt(np.maximum(own**2 - (weight / rod.length) ** 2, 0.0))
    clearance = model.wellbore.clearance.reshape(-1, 2).mean(axis=1)
    load = np.maximum(2.0 * np.sqrt(rod.bending * across / clearance), 1.94 * np.cbrt(rod.bending * own**2))
    buckled = np.flatnonzero(extremes(scene).weight_on_bit - np.cumsum(weight) > load)
    return float(rod.arc[buckled[-1] + 1]) if buckled.size else 0.0


def counts_above(above: list[Tube], finer: float = 1.0) -> list[int]:
    """Elements of each piece above the joint; `finer` times the number of elements as long as `LONGEST_ABOVE`."""
    return [math.ceil(finer * tube.length / LONGEST_ABOVE - 1e-9) for tube in above]


def _mean_curvature(scene: Scene, above: Rod, points: Axis) -> Axis:
    """The hole at Gauss points with the mean curvature of their half of the element, wherever in it a dogleg begins."""
    arc = np.interp(np.arange(points.along.size + 1), np.arange(0, points.along.size + 1, 2), above.arc)
    ends = axis_at(scene, scene.length - arc)
    if ends is None:
        return points
    bend = np.diff(ends.tangent, axis=0) / np.diff(arc)[:, None]
    bend -= (bend * points.tangent).sum(-1, keepdims=True) * points.tangent
    curvature = np.linalg.norm(bend, axis=-1)
    normal = np.where(curvature[:, None] > 0.0, bend / np.maximum(curvature, 1e-300)[:, None], points.normal)
    return points._replace(normal=normal, curvature=curvature)


def joined_workspace(scene: Scene, model: DiscreteModel, constrained: Mask, loaded: int = 0) -> Workspace:
    """Workspace of the joined form.

    Args:
        scene: A scene with a joint.
        model: Its discrete model.
        constrained: Constrained unknowns of bit and top, shape (2, 7).
        loaded: Nodes that an effect may load: all or none.
    """
    rod, joint = model.rod, joint_of(scene) or 0.0
    first = int(np.searchsorted(rod.arc, joint - 1e-6))
    m = rod.length.size - first
    nodes, points, twist = axis_at(scene, rod.arc[-1] - rod.arc[first:]), model.wellbore.axis, np.zeros(m)
    if nodes is not None and points is not None:
        part = part_of(rod, first, rod.length.size)
        twist = np.diff(untwisted(part, np.column_stack((nodes.centre, nodes.tangent, np.zeros(m + 1))))) / part.length
        points = _mean_curvature(scene, part, Axis(*(field[2 * first :].copy() for field in points)))
    return make_workspace(rod, m, constrained, nodes, points, twist, loaded)


class JointMotion:
    """Sideways motion at the joint of a run: a string that whirls there would whirl above it too."""

    def __init__(self, scene: Scene, rod: Rod) -> None:
        joint = joint_of(scene)
        self._depth = scene.unit_system.text(scene.length - (joint or 0.0), "length")
        self._node = None if joint is None else int(np.searchsorted(rod.arc, joint - 1e-6))
        self._lever, self._since, self._fastest = float(rod.outer_radius[self._node or 0]), 0.0, 0.0
        self._squares, self._frames, self._spin = 0.0, 0, math.nan

    def update(self, time: Array, u: Array, v: Array, top_speed: Array) -> list[str]:
        """Check frames, in order; returns a sentence once, where the string whirls at the joint.

        Args:
            time: Times of F frames [s].
            u: Node rows, shape (F, n + 1, 7).
            v: Their velocities.
            top_speed: Of the top drive [rad/s], shape (F,).
        """
        if self._node is None or not time.size:
            return []
        spin = u[:, self._node, SPIN]
        self._spin = float(spin[0]) if math.isnan(self._spin) else self._spin
        if abs(spin[0] - self._spin) < math.tau:
            return []
        along, moving = u[:, self._node, 3:6], v[:, self._node, :3]
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        sideways = moving - (moving * along).sum(1, keepdims=True) * along
        self._since = self._since if self._frames else float(time[0])
        self._squares, self._frames = self._squares + float((sideways**2).sum()), self._frames + time.size
        self._fastest = max(self._fastest, float(np.abs(top_speed).max()))
        if time[-1] < self._since + OVER:
            return []
        speed, surface = math.sqrt(self._squares / self._frames), self._lever * self._fastest
        self._squares, self._frames = 0.0, 0
        if not speed > WHIRLS * surface > 0.0:
            return []
        self._node = None
        told = (
            f"at {time[-1]:.3f} s the string whirled where its lateral motion ends, at {self._depth} "
            f"(`numerics.lateral_from`): it moved sideways at {speed:.2g} m/s, its surface turns at {surface:.2g} "
            "m/s; hookload, torque and onset may differ from the whole string's: give a smaller depth, or 0 m"
        )
        return [told]
