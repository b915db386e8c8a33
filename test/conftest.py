# SPDX-License-Identifier: Apache-2.0
"""Fixtures of all rooms (`shared_fixtures.py`)."""

from shared_fixtures import bench_run, bench_scene, browse, make_frame, make_geometry, small_disk

__all__ = ["bench_run", "bench_scene", "browse", "make_frame", "make_geometry", "small_disk"]
