# SPDX-License-Identifier: Apache-2.0
"""The package builds with colcon, and its executables run through the ament index as `ros2 run` runs them."""

import os
import shutil
import subprocess
import sys
import venv
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
    for node in (*NODES, "twin", "watch"):
        assert f"ok: {node} -> install/drill_twin/lib/drill_twin/{node}" in done.stdout
    assert "ok: a run from the installed package" in done.stdout
    assert "ok: the README from the workspace" in done.stdout


@pytest.mark.long
def test_a_wheel_brings_one_command_and_the_executables_of_ros2_run(tmp_path):
    """Into an environment that has nothing else but the path of the libraries that the tests use."""
    source = tmp_path / "source"
    for name in ("drill_twin", "config", "resource"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("setup.py", "setup.cfg", "package.xml", "README.md", "LICENSE", "MANIFEST.in", "colcon.pkg"):
        shutil.copy(ROOT / name, source)
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True)
    (packages,) = environment.glob("lib/python*/site-packages")
    (packages / "libraries.pth").write_text("".join(f"{path}\n" for path in sys.path if "site-packages" in path))
    before = {file.name for file in (environment / "bin").iterdir()}
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    _run([*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(tmp_path), str(source)])
    (wheel,) = tmp_path.glob("*.whl")
    _run([str(environment / "bin" / "pip"), "install", "--no-deps", "--no-index", str(wheel)])
    assert {file.name for file in (environment / "bin").iterdir()} - before == {"drill-twin"}
    assert {file.name for file in (environment / "lib" / "drill_twin").iterdir()} == {*NODES, "twin", "watch"}
    for command in ("lib/drill_twin/simulator", "bin/drill-twin ros node simulator"):
        said = _run([str(environment / command.split()[0]), *command.split()[1:], "--help"])
        assert said.startswith("usage: simulator ")
    from_share = f"import drill_twin.scene as s; assert str(s.presets()['pa6_bench']).startswith('{environment}/share')"
    _run([str(environment / "bin" / "python"), "-c", from_share])


def _run(command):
    """Output of a command that must succeed, run where nothing of the clone is on the path."""
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        command, cwd="/", env=environment, capture_output=True, text=True, timeout=300, check=False
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


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
