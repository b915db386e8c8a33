# SPDX-License-Identifier: Apache-2.0
"""Set-points that a driver plays: its parameters' set-points, and the transition to others in a run, without a jump."""

from collections.abc import Callable
from types import SimpleNamespace

from drill_twin.core.errors import ParameterError, SceneError
from drill_twin.ros.core.scene_parameters import scene_of
from drill_twin.scene.blocks.numerics import frame_period_ns
from drill_twin.scene.set_points import Schedule
from drill_twin.scene.set_points.command import Command

Plan = Callable[[float], Command]
"""Simulated time [s] -> set-points."""


def transition(before: Command, after: Plan, start: float, duration: float) -> Plan:
    """Plan that leads to another by a cubic step with zero slope at both ends (the STEP of the schedules).

    Args:
        before: Set-points in force before.
        after: Plan that holds afterwards.
        start: Simulated time at the start of the transition [s].
        duration: Duration of the transition [s].
    """

    def at(time: float) -> Command:
        passed = (time - start) / duration if duration > 0.0 else 1.0
        if passed >= 1.0:
            return after(time)
        return before.mixed(after(time), max(passed, 0.0) ** 2 * (3.0 - 2.0 * max(passed, 0.0)))

    return at


class SetPointPlan:
    """Set-points over simulated time: the scene's schedule, or a table of measured ones.

    Raises:
        DrillTwinError: The parameters are of no scene, or their set-points are not valid in it.
    """

    def __init__(self, settings: SimpleNamespace) -> None:
        scene = scene_of(settings)
        self.schedule = Schedule.from_scene(scene)
        """Schedule of the present set-points."""
        self.at: Plan = self.schedule.at
        """Plan that is played."""
        self._planned = _planned(settings)
        self.period = frame_period_ns(settings.frame_rate or scene.numerics.frame_rate)
        """Simulated time from set-point to set-point [ns]."""
        self.plays = scene.name
        """Name of the scene, or the file of the table."""
        self.report = ""
        """Report on the table, where there is one."""
        if self.schedule.record is not None and scene.rig.table is not None:
            self.plays, self.report = str(scene.rig.table.file), self.schedule.record.report

    def begin_again(self) -> None:
        """Play as a launch with these set-points would: a transition belongs to the run before."""
        self.at = self.schedule.at

    def change(self, settings: SimpleNamespace, before: Command | None, time: float) -> bool:
        """Go over to the settings' set-points from the set-points in force at a time [s]; False if they agree."""
        if _planned(settings) == self._planned:
            return False
        self._planned = _planned(settings)
        self.schedule = Schedule.from_scene(scene_of(settings))
        self.at = self.schedule.at
        if before is not None:
            self.at = transition(before, self.schedule.at, time, settings.change_time)
        return True


def check_set_points(settings: SimpleNamespace, present: SimpleNamespace) -> None:
    """Refuse new set-points that are not valid in the scene, by raising a DrillTwinError; present ones pass."""
    if _planned(settings) != _planned(present):
        try:
            scene_of(settings)
        except SceneError as error:
            pairs = zip(("wob", "rpm"), _planned(settings), _planned(present), strict=True)
            names = ", ".join(name for name, wanted, planned in pairs if wanted != planned)
            told = str(error)  # begins with the scene and the key, which are not what was set
            raise ParameterError(f"{names}: {told[max(told.find('expected'), 0) :]}") from error


def _planned(settings: SimpleNamespace) -> tuple[str, str]:
    return settings.wob, settings.rpm
