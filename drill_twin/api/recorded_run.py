# SPDX-License-Identifier: Apache-2.0
"""A recorded run computed again: the commands of a bag or a record, with the numbers of its scene or with others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.api.compared_quantities import Case, quantities
from drill_twin.api.result import Result, read_bag
from drill_twin.api.scenes import Overrides, as_scene
from drill_twin.api.simulation import Simulation
from drill_twin.core.errors import ArgumentError, RunError
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.virtual_bags import RecordBag, is_record
from drill_twin.io.messages.stamps import NANOSECONDS, raw_header_stamp
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES
from drill_twin.runs.recorded_commands import RecordedCommands, recorded_commands
from drill_twin.scene import Scene
from drill_twin.scene.blocks.rig import SetPoint
from drill_twin.scene.load import override
from drill_twin.scene.set_points import Command, Schedule

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OF_THE_BAG = (
    *("wob", "rpm", "duration", "rig.weight_on_bit", "rig.rotation", "rig.table", "rig.duration"),
    *(f"rig.block.{name}" for name in SetPoint.model_fields),
)
_FRAMES = (RIG_STATE, MARKS_STATE, STRING_POSES)


@dataclass(frozen=True, eq=False)
class Rerun:
    """A recorded run beside the same commands computed again."""

    recorded: Result
    """The bag."""
    computed: Result
    """The run with the commands of the bag."""
    commands: RecordedCommands
    """Commands that the bag holds."""
    stopped: str = ""
    """Reason why the computed run ended before the recorded one; empty where it did not."""

    @cached_property
    def same_frames(self) -> int:
        """Number of frames, from the first on, whose messages equal the recorded ones bit for bit."""
        recorded, computed = (_frames(result.recording.bag) for result in (self.recorded, self.computed))
        same = (messages.items() <= computed.get(stamp, {}).items() for stamp, messages in recorded.items())
        return sum(takewhile(bool, same))

    @property
    def identical(self) -> bool:
        """True where every recorded frame was computed again bit for bit."""
        return self.same_frames == len(_frames(self.recorded.recording.bag))

    @cached_property
    def largest_difference(self) -> float:
        """Largest distance between recorded and computed positions of a mark [m]; nan without marks in both."""
        recorded, computed = self.recorded.marks, self.computed.marks
        _, first, second = np.intersect1d(recorded.stamp, computed.stamp, return_indices=True)
        if not first.size or recorded.position.shape[1:] != computed.position.shape[1:]:
            return float("nan")
        return float(np.nanmax(np.linalg.norm(recorded.position[first] - computed.position[second], axis=-1)))

    @property
    def of_record(self) -> bool:
        """True for the record of a rig, whose set-points may have been replaced."""
        return isinstance(self.recorded.recording.bag, RecordBag)

    def table(self) -> list[tuple[str, ...]]:
        """Quantity with its unit, recorded value and computed value, as `drill-twin compare` shows them."""
        found = quantities([Case("recorded", self.recorded, None), Case("computed again", self.computed, None)])
        return [row.cells(self.computed.recording.units) for row in found]

    def plot(self) -> Figure:
        """Figure of both runs over time: distance of the marks from the axis, hookload, torque, speed of the bit."""
        from drill_twin.report.figures.over_time import draw_runs

        runs = [("recorded", self.recorded.recording), ("computed again", self.computed.recording)]
        return draw_runs(runs, "Recorded, and computed again", self.computed.recording.units)


def rerun(
    bag: str | Path,
    overrides: Overrides | None = None,
    *,
    scene: Scene | str | Path | None = None,
    namespace: str | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Rerun:
    """Compute a recorded run again, under the commands of the bag, or the set-points that a rig recorded.

    Without overrides the frames of a bag are computed again bit for bit, if it was recorded in lockstep or without ROS
    by the same version on the same kind of processor. In real time a command may have come a frame late: the runs then
    differ by what that changes, and after the onset of whirl, where motion is chaotic, by more.

    Args:
        bag: Folder of a run or a bag, or a bag file; or the record of a rig (CSV, MAT, LAS, WITSML).
        overrides: Values that replace the scene's values, but no set-points, which the bag decides. A weight on bit or
            a speed takes the place of the record's.
        scene: The scene, where the bag holds none; of a record always.
        namespace: Namespace of the twin, where the bag holds several.
        progress: Called with the simulated time and that at the end [s] after each frame.

    Raises:
        ArgumentError: An override is a set-point of a bag, or a record comes without a scene.
        BagError: Not a bag of this package, without a scene where none is given, or without rig states.
        SceneError: An override does not fit the scene.
    """
    record = is_record(Path(bag))
    if record and scene is None:
        raise ArgumentError(
            f"{bag}: expected the scene of the rig beside its record, found none; name it with --scene "
            "(`drill-twin scene new` makes a scene of a well plan)"
        )
    for key in () if record else overrides or {}:
        if any(key == fixed or key.startswith(f"{fixed}.") for fixed in _OF_THE_BAG):
            raise ArgumentError(
                f"{key}: expected a key that the bag does not decide, found one of the set-points, which the "
                "bag decides; to change them, run the scene itself"
            )
    recorded = read_bag(bag, scene=None if scene is None else as_scene(scene), namespace=namespace)
    described = recorded.scene
    if record:
        described, commands = _of_record(recorded, dict(overrides or {}))
    else:
        commands = recorded_commands(recorded.recording.bag, planned(described), block=described.rig.moves_block)
        described = override(described, {"numerics.frame_rate": NANOSECONDS / commands.period, **(overrides or {})})
    simulation = Simulation(described)
    end, stopped = len(commands.commands) * commands.period / NANOSECONDS, ""
    try:
        for command in commands.commands:
            simulation.follow(command)
            if progress is not None:
                progress(simulation.time, end)
    except RunError as error:
        if simulation.state is None:
            raise
        stopped = str(error)
    return Rerun(recorded, simulation.result(), commands, stopped)


def _of_record(recorded: Result, changes: dict[str, Any]) -> tuple[Scene, RecordedCommands]:
    """The scene under the set-points of a record where no others are given, and the set-points of each frame."""
    rig, path, told = recorded.recording.rig, recorded.recording.path, list[str]()
    for name, short, values in (("weight_on_bit", "wob", rig.bit_force), ("rotation", "rpm", rig.top_drive_speed)):
        given = any(key == short or key.startswith(f"rig.{name}") for key in changes)
        if np.isfinite(values).any() and not given:
            changes[f"rig.{name}"] = {"shape": "table"}
            told.append(name.replace("_", " "))
    length = float(rig.time[-1] - rig.time[0])
    if told:
        changes["rig.table"] = {"file": str(path.absolute()), "longest_gap": length}
    scene = override(recorded.scene, {"rig.duration": length, **changes})
    schedule, period = Schedule.from_scene(scene), round(NANOSECONDS / scene.numerics.frame_rate)
    frames = range(1, round(length * NANOSECONDS / period) + 1)
    source = f"{path.name}: {' and '.join(told) or 'none'}, without spikes and gaps; the others are the scene's"
    if rig.time[0] > 0.0:
        source += f"; time 0 of the run is {rig.time[0]:g} s of the record"
    return scene, RecordedCommands(source, period, [schedule.at(k * period / NANOSECONDS) for k in frames], 0.0)


def planned(scene: Scene) -> Callable[[float], Command]:
    """Set-points of a scene over time; where it plays a table, whose file may be gone, its first set-points."""
    if scene.rig.table is not None:
        return lambda _: Command(*scene.rig.first)
    return Schedule.from_scene(scene).at


def _frames(bag: Bag) -> dict[int, dict[str, bytes]]:
    """Messages of each frame by stamp [ns] and topic, without the zeros with which DDS fills them up."""
    frames: dict[int, dict[str, bytes]] = {}
    for topic, _, raw in bag.messages(_FRAMES):
        frames.setdefault(raw_header_stamp(raw), {})[topic] = raw.rstrip(b"\0")
    return frames
