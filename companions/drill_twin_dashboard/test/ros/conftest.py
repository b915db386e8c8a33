# SPDX-License-Identifier: Apache-2.0
"""Fixtures of tests with nodes as processes (`test/process_bench.py`)."""

from process_bench import bench, compiled, joints, make_bench, module_bench, payloads, small_bag

__all__ = ["bench", "compiled", "joints", "make_bench", "module_bench", "payloads", "small_bag"]
