# SPDX-License-Identifier: Apache-2.0
"""Fixtures shared with the tests of the core (`test/shared_fixtures.py`, `test/command_fixtures.py`)."""

from command_fixtures import call, inside, process, start
from shared_fixtures import bench_run, bench_scene, browse, make_frame, make_geometry, small_disk

__all__ = [
    "bench_run", "bench_scene", "browse", "call", "inside", "make_frame", "make_geometry", "process", "small_disk",
    "start",
]  # fmt: skip
