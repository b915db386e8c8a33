# SPDX-License-Identifier: Apache-2.0
"""Record of frames as the compiled loop makes it: a table of numbers, one row a frame, and views of its columns."""

from typing import Any, NamedTuple, Self

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.solver.state import COUNTERS, HALVINGS, ITERATIONS, LOOSE_STEPS, STEPS
from drill_twin.dynamics.twin.frame import EnergyBalance, Frame, Frames, Intervention, MarkStates, RigState, StepStats
from drill_twin.physics.model.section_stress import SCALARS


class FrameSeries(NamedTuple):
    """Record of each of F frames, in the order in which `drill_twin.dynamics.twin.frame_kernel` writes it."""

    time: Array  # (F,) [s]
    command: Array  # (F, 3) set-points reached, as a `Command`
    rig: Array  # (F, 12) fields of `RigState`
    counted: Array  # (F, counters) of the frame
    position: Array  # (F, m, 3) of the marks [m]
    centre: Array  # (F, m, 3) [m]
    spin: Array  # (F, m) [rad]
    wall_force: Array  # (F, m) [N]
    string: Array  # (F, 3) largest wall force of a node [N], largest penetration [m], fraction of nodes in contact


class NodeSeries(NamedTuple):
    """The rest of recorded frames, for messages."""

    u: Array  # (F, n + 1, 7) node rows (r, r', psi)
    v: Array  # (F, n + 1, 7) their velocities
    tangents: Array  # (F, n + 1, 3)
    node_force: Array  # (F, n + 1) of the wall [N]
    velocity: Array  # (F, m, 3) of the marks [m/s]
    spin_rate: Array  # (F, m) [rad/s]
    deepest: Array  # (F, 2) largest penetration into the wall, and its distance from the bit [m]
    stress: Array  # (F, s, scalars) of the sections of `fatigue`


class RigSeries(NamedTuple):
    """Rig and bit over recorded frames, each of shape (F,); fields as in `RigState`."""

    top_drive_speed: Array
    top_drive_torque: Array
    bit_speed: Array
    bit_torque: Array
    bit_force: Array
    hookload: Array

    @classmethod
    def of(cls, frames: FrameSeries) -> Self:
        """Columns of recorded frames."""
        return cls(*(frames.rig[:, RigState._fields.index(name)] for name in cls._fields))


class Record(NamedTuple):
    """Room for F frames."""

    table: Array
    """All numbers, shape (F, columns)."""
    kind: Any
    """numpy's type of a row."""
    frames: FrameSeries
    """Views of its columns."""
    nodes: NodeSeries | None
    """The same of the rest, if that is recorded."""
    interventions: dict[int, Intervention]
    """Records of the step guard by row."""

    @property
    def size(self) -> int:
        """Number of frames that it takes."""
        return len(self.table)


def row_type(nodes: int, marks: int, sections: int, *, whole: bool) -> Any:
    """Numpy's type of a row, for a number of nodes, marks, and sections whose stress is counted.

    Args:
        nodes: Number of nodes.
        marks: Number of marks.
        sections: Number of sections.
        whole: Include the fields of `NodeSeries`.
    """
    n, m = nodes, marks
    frames = FrameSeries((), (3,), (len(RigState._fields),), (COUNTERS,), (m, 3), (m, 3), (m,), (m,), (3,))  # type: ignore[arg-type]
    rest = NodeSeries((n, 7), (n, 7), (n, 3), (n,), (m, 3), (m,), (2,), (sections, len(SCALARS)))  # type: ignore[arg-type]
    shapes = frames._asdict() | (rest._asdict() if whole else {})
    return np.dtype([(name, float, shape) for name, shape in shapes.items()])


def make_record(kind: Any, frames: int) -> Record:
    """Room for a number of frames, whose rows are of a type."""
    rows = np.empty(frames, kind)
    table = rows.view(float).reshape(frames, kind.itemsize // 8)
    whole = NodeSeries._fields[0] in kind.names
    series = FrameSeries(*(rows[name] for name in FrameSeries._fields))
    return Record(table, kind, series, NodeSeries(*(rows[name] for name in NodeSeries._fields)) if whole else None, {})


def frame_of(
    row: Array, kind: Any, wall_seconds: float, intervention: Intervention | None, energy: EnergyBalance | None
) -> Frame:
    """Make a frame of a recorded row with nodes; its arrays are views of the row.

    Args:
        row: Row of `Record.table`, shape (columns,).
        kind: `Record.kind`.
        wall_seconds: Wall-clock time of its computation [s].
        intervention: Record of the step guard, if any.
        energy: Energy balance at its end, if any.
    """
    time, _, rig, counted, position, centre, spin, wall_force, _, *rest = np.ndarray((), kind, row).item()
    u, v, tangents, node_force, velocity, spin_rate, deepest, stress = rest
    depth, place = deepest.tolist()
    return Frame(
        time, u[:, 0:3], v[:, 0:3], tangents, u[:, 6], v[:, 6], node_force, depth, place,
        MarkStates(position, velocity, spin, spin_rate, wall_force, centre), RigState(*rig.tolist()),
        _stats(counted.tolist(), wall_seconds), intervention, energy, stress if len(stress) else None,
    )  # fmt: skip


def frames_of(record: Record, count: int, wall_seconds: float, energy: EnergyBalance | None) -> Frames:
    """Frames of a record with nodes; views of its arrays, which hold until it is filled again.

    Args:
        record: The record.
        count: Number of its rows that were filled.
        wall_seconds: Wall-clock time of the computation of all [s].
        energy: Energy balance at the end of the last one, if any.
    """
    seen = FrameSeries(*(array[:count] for array in record.frames))
    nodes = NodeSeries(*(array[:count] for array in record.nodes or ()))
    return Frames(
        time=seen.time, positions=nodes.u[..., 0:3], tangents=nodes.tangents, spin=nodes.u[..., 6],
        wall_force=nodes.node_force, wall_depth=nodes.deepest[:, 0], wall_depth_at=nodes.deepest[:, 1],
        marks=MarkStates(seen.position, nodes.velocity, seen.spin, nodes.spin_rate, seen.wall_force, seen.centre),
        rig=seen.rig, stats=_stats(seen.counted.sum(axis=0).tolist(), wall_seconds),
        interventions=tuple(record.interventions.values()), energy=energy,
        stress=nodes.stress if nodes.stress.shape[1] else None, u=nodes.u, v=nodes.v,
    )  # fmt: skip


def _stats(counted: list[float], wall_seconds: float) -> StepStats:
    steps, iterations, cut, loose = (int(counted[k]) for k in (STEPS, ITERATIONS, HALVINGS, LOOSE_STEPS))
    return StepStats(steps, iterations, cut, loose, wall_seconds)
