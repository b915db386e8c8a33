# SPDX-License-Identifier: Apache-2.0
"""The script that runs the `ros2` lines of the pages, as a module."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

SCRIPT = Path(__file__).resolve().parents[1] / ".ci" / "ros2_lines.py"


def ros2_lines() -> ModuleType:
    """The module `.ci/ros2_lines.py`, which is in no package."""
    spec = spec_from_file_location("ros2_lines", SCRIPT)
    module = sys.modules["ros2_lines"] = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
