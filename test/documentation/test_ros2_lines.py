# SPDX-License-Identifier: Apache-2.0
"""Lines of the pages that begin with `ros2`: `.ci/ros2_lines.py` runs each, and its table has no other."""

import os
import subprocess
import sys

from documented_lines import SCRIPT, ros2_lines


def test_the_table_has_exactly_the_documented_lines():
    lines = ros2_lines()
    known = [*lines.PRINTS, *lines.NEEDS]
    assert sorted(known) == sorted(lines.documented()), "each documented line needs an entry, and no entry is left over"


def test_without_the_tools_it_says_why_it_runs_nothing(tmp_path):
    bare = {**os.environ, "PATH": str(tmp_path)}
    done = subprocess.run([sys.executable, str(SCRIPT)], capture_output=True, text=True, check=False, env=bare)
    assert done.returncode == 0
    assert done.stdout.startswith("skipped: no ros2 on PATH")
