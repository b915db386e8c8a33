# SPDX-License-Identifier: Apache-2.0
"""Names of the shapes that a set-point can have over time.

Another package adds shapes through the entry-point group ``drill_twin.schedules``: the entry's name is the shape in a
scene, its value a function (``saw = my_package.shapes:saw``) from a set-point to its value over time.
"""

from importlib import metadata

GROUP = "drill_twin.schedules"
"""Entry-point group of shapes in other packages."""
BUILT_IN = ("constant", "step", "ramp", "table")
"""Shapes of this package; another package cannot replace them."""
ADDED = {entry.name: entry for entry in metadata.entry_points(group=GROUP) if entry.name not in BUILT_IN}
"""Entry points of the shapes of other packages, by name."""
SHAPES = (*BUILT_IN, *sorted(ADDED))
"""Names of all shapes."""
