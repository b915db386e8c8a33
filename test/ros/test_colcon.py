# SPDX-License-Identifier: Apache-2.0
"""The package builds with colcon, and its executables run through the ament index as `ros2 run` runs them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drill_twin.ros.entry_points import NODES

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_the_package_builds_and_its_executables_run():
    pytest.importorskip("colcon_core", reason="needs colcon: pip install -e '.[test]'")
    done = subprocess.run(
        ["bash", str(ROOT / ".ci" / "colcon")], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for node in (*NODES, "twin"):
        assert f"ok: {node} -> install/drill_twin/lib/drill_twin/{node}" in done.stdout
    assert "ok: a run from the installed package" in done.stdout
    assert "ok: the README from the workspace" in done.stdout


@pytest.mark.long
def test_every_line_of_the_readme_works_in_the_virtual_environment():
    folder = Path(sys.executable).parent
    if not (folder / "drill-twin").exists():
        pytest.skip("needs the installed command: pip install -e .")
    path = os.pathsep.join([str(folder), os.environ["PATH"]])
    done = subprocess.run(
        ["bash", str(ROOT / ".ci" / "readme")],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env=dict(os.environ, PATH=path),
    )
    assert done.returncode == 0, done.stdout + done.stderr
