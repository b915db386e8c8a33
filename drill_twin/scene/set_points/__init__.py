# SPDX-License-Identifier: Apache-2.0
"""Set-points of the rig over time: constant, step, ramp, or recorded."""

from drill_twin.scene.set_points.command import Command
from drill_twin.scene.set_points.schedule import Schedule, extremes
from drill_twin.scene.set_points.tables import Table, read_table

__all__ = ["Command", "Schedule", "Table", "extremes", "read_table"]
