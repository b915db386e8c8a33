# SPDX-License-Identifier: Apache-2.0
"""The package builds with colcon, and its executables run through the ament index as `ros2 run` runs them."""

import subprocess
from pathlib import Path

import pytest

from drill_twin.ros.entry_points import NODES

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_the_package_builds_and_its_executables_run():
    pytest.importorskip("colcon_core", reason="needs colcon: pip install -e '.[test]'")
    done = subprocess.run(
        ["bash", str(ROOT / ".ci" / "colcon")], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for node in (*NODES, "twin"):
        assert f"ok: {node} -> install/drill_twin/lib/drill_twin/{node}" in done.stdout
    assert "ok: a run from the installed package" in done.stdout
