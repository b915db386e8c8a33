# SPDX-License-Identifier: Apache-2.0
"""The package builds with colcon, and its executables run through the ament index as `ros2 run` runs them."""

import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path
from zipfile import ZipFile

import pytest

import drill_twin
from drill_twin.core.files.kept_files import cache_folder
from drill_twin.ros.entry_points import node_names

ROOT = Path(__file__).resolve().parents[2]
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")
WHEEL = (*PIP, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir")


@pytest.mark.long
def test_the_package_builds_and_its_executables_run():
    pytest.importorskip("colcon_core", reason="needs colcon: pip install -e '.[test]'")
    done = subprocess.run(
        ["bash", str(ROOT / ".ci" / "colcon")], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for node in (*node_names(), "twin", "watch"):
        assert f"ok: {node} -> install/drill_twin/lib/drill_twin/{node}" in done.stdout
    assert "ok: a run from the installed package" in done.stdout
    assert "ok: the README from the workspace" in done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder with the sdist of what git would hand over, and wheels: `a` of the tree, `b` of the sdist, companions."""
    folder = tmp_path_factory.mktemp("built")
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0"):
        if name and (ROOT / name).is_file():
            target = folder / "source" / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target)
    make_sdist = "import sys; from setuptools import build_meta; build_meta.build_sdist(sys.argv[1])"
    _run([sys.executable, "-c", make_sdist, str(folder)], folder / "source")
    (sdist,) = folder.glob("*.tar.gz")
    for name, source in (("a", folder / "source"), ("b", sdist)):
        _run([*WHEEL, str(folder / name), str(source)])
    for source in (folder / "source" / "companions").iterdir():
        _run([*WHEEL, str(folder / "companions"), str(source)])
    return folder


@pytest.mark.long
def test_the_wheel_has_what_a_user_needs_and_so_has_that_of_the_sdist(built):
    first, second = (ZipFile(next((built / name).glob("*.whl"))) for name in ("a", "b"))
    crc = [{item.filename: item.CRC for item in wheel.infolist() if not item.is_dir()} for wheel in (first, second)]
    assert crc[0] == crc[1]
    tracked = {path.relative_to(built / "source") for path in (built / "source").rglob("*") if path.is_file()}
    data = f"drill_twin-{drill_twin.__version__}.data/data/share/drill_twin"
    needed = {str(path) for path in tracked if path.parts[0] == "drill_twin"}
    needed |= {f"{data}/{path.relative_to('config')}" for path in tracked if path.parts[0] == "config"}
    names = set(crc[0])
    assert needed <= names
    others = {name for name in names - needed if ".dist-info/" not in name}
    assert {Path(name).parent.name for name in others} == {"packages", "drill_twin", "bin", "hook"}
    assert not [name for name in names if "test" in Path(name).parts or "__pycache__" in name]


@pytest.mark.long
def test_the_wheel_of_a_companion_has_its_package_and_its_config(built):
    for wheel in map(ZipFile, (built / "companions").glob("*.whl")):
        name = next(path.partition("/")[0] for path in wheel.namelist() if path.endswith("/py.typed"))
        folder = built / "source" / "companions" / name
        files = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
        data = f"{name}-{drill_twin.__version__}.data/data/share/{name}"
        needed = {str(path) for path in files if path.parts[0] == name}
        needed |= {f"{data}/{path.relative_to('config')}" for path in files if path.parts[0] == "config"}
        assert len(needed) > 10
        assert needed <= set(wheel.namelist())


REFUSED_TO_LISTEN = """
import sys
def refuse(event, arguments):
    assert event != "socket.bind", arguments
sys.addaudithook(refuse)
from drill_twin.cli import run_command
sys.exit(run_command(sys.argv[1:]))
"""


@pytest.mark.long
def test_the_wheel_of_the_core_runs_alone_from_an_empty_environment(built, tmp_path):
    """It has the libraries that the tests use, their kernels, an empty home, no clone around and no companion."""
    environment, where = (
        tmp_path / "environment",
        {"HOME": str(tmp_path / "home"), "DRILL_TWIN_CACHE": str(cache_folder())},
    )
    (tmp_path / "home").mkdir()
    venv.create(environment)
    (packages,) = environment.glob("lib/python*/site-packages")
    for file in (file for path in sys.path if "site-packages" in path for file in Path(path).iterdir()):
        if not file.name.startswith(("drill_twin", "__editable__")) and not (packages / file.name).exists():
            (packages / file.name).symlink_to(file)
    before = {file.name for file in (environment / "bin").iterdir()}
    (wheel,) = (built / "b").glob("*.whl")
    _run([*PIP, "--python", str(environment), "install", "--no-deps", "--no-index", str(wheel)])
    assert {file.name for file in (environment / "bin").iterdir()} - before == {"drill-twin"}
    assert {file.name for file in (environment / "lib" / "drill_twin").iterdir()} == {*node_names(), "twin", "watch"}
    from_share = f"import drill_twin.scene as s; assert str(s.presets()['pa6_bench']).startswith('{environment}/share')"
    _run([str(environment / "bin" / "python"), "-c", from_share])
    for command in ("lib/drill_twin/simulator", "bin/drill-twin ros node simulator"):
        said = _run([str(environment / command.split()[0]), *command.split()[1:], "--help"])
        assert said.startswith("usage: simulator ")
    python, command_line = (str(environment / "bin" / name) for name in ("python", "drill-twin"))
    for command in (
        "run pa6_bench --duration 1 --out run",
        "report run/bag_0 --out report",
        "modes pa6_bench",
        "statics pa6_bench",
        "compare pa6_bench pa6_bench,wob=20N --duration 1 --repeats 1 --out compare",
    ):
        _run([python, "-c", REFUSED_TO_LISTEN, *command.split()], tmp_path, **where)
    _run([command_line, "ros", "demo", "--duration", "1", "--pace", "fast", "--out", "demo"], tmp_path, **where)
    for file in ("run/summary.json", "report/report.html", "demo/report.html"):
        assert (tmp_path / file).stat().st_size > 0
    for command, package in (
        ("fit rec.csv --scene two_mass", "drill_twin_studies"),
        ("watch run/bag_0", "drill_twin_dashboard"),
        ("export run/bag_0 --drillbotics", "drill_twin_rig"),
        ("ros node gateway", "drill_twin_rig"),
    ):
        done = subprocess.run(
            [command_line, *command.split()], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 2
        assert f"needs the package {package}" in done.stderr
    _run(
        [
            *PIP,
            "--python",
            str(environment),
            "install",
            "--no-deps",
            "--no-index",
            *map(str, (built / "companions").glob("*.whl")),
        ]
    )
    assert "Usage: drill-twin fit" in _run([command_line, "fit", "--help"])
    assert _run([str(environment / "lib" / "drill_twin" / "gateway"), "--help"]).startswith("usage: gateway ")


def _run(command, folder=Path("/"), **variables):
    """Output of a command that must succeed, run where nothing of the clone is on the path."""
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        command, cwd=folder, env=environment | variables, capture_output=True, text=True, timeout=300, check=False
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.nightly
def test_every_line_of_the_readme_works_in_the_virtual_environment():
    """A change is guarded by the same lines in the workspace, and by `test/documentation/test_commands.py` here."""
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
