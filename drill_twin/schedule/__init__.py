# SPDX-License-Identifier: Apache-2.0
"""Set-points of the rig over time: constant, step, ramp, or recorded."""

from drill_twin.schedule.command import Command
from drill_twin.schedule.extremes import extremes
from drill_twin.schedule.schedule import Schedule
from drill_twin.schedule.tables import Table, read_table

__all__ = ["Command", "Schedule", "Table", "extremes", "read_table"]
