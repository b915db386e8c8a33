# SPDX-License-Identifier: Apache-2.0
"""The built wheel works without a clone, the API loads lazily, and the examples run and pass a strict type check."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import drill_twin as dt

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"
RUN = """
import json
import drill_twin as dt
from drill_twin.scene import config_dir
result = dt.Simulation("pa6_bench").run(duration=0.5)
print(json.dumps({"package": dt.__file__, "scenes": str(config_dir()), "samples": result.time.size}))
"""


def run(*command: str, cwd: Path = ROOT, **more: str) -> str:
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | more
    done = subprocess.run(
        [sys.executable, *command], cwd=cwd, env=environment, capture_output=True, text=True, timeout=900, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_wheel_runs_a_scene_without_a_clone(tmp_path):
    unwanted = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "build", "install", "log", "out", "test")
    clone = shutil.copytree(ROOT, tmp_path / "clone", ignore=unwanted)
    run("-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(tmp_path), str(clone))
    shutil.rmtree(clone)
    (wheel,) = tmp_path.glob("drill_twin-*.whl")
    contents = zipfile.ZipFile(wheel).namelist()
    assert not [
        name for name in contents if "evidence" in name or "/config/hard/" in name or "/share/drill_twin/hard" in name
    ]
    assert "drill_twin/scene/paths.py" in contents
    site = tmp_path / "site"
    run("-m", "pip", "install", "-q", "--no-deps", "--target", str(site), str(wheel))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    found = json.loads(run("-c", RUN, cwd=elsewhere, PYTHONPATH=str(site)))
    assert Path(found["package"]).is_relative_to(site)
    assert Path(found["scenes"]).is_relative_to(site)
    assert found["samples"] == 50


@pytest.mark.long
def test_the_examples_pass_a_strict_type_check():
    scripts = [str(EXAMPLES / name) for name in ("analyst.py", "controller.py")]
    run("-m", "mypy", "--strict", *scripts, PYTHONPATH=str(ROOT))


def test_the_examples_run(tmp_path):
    said = run(str(EXAMPLES / "analyst.py"), "1", str(tmp_path / "analyst"), PYTHONPATH=str(ROOT))
    assert said.count("hookload") == 3
    assert "1.00 s: " in said
    assert (tmp_path / "analyst" / "displacement.png").exists()
    said = run(str(EXAMPLES / "controller.py"), "1", PYTHONPATH=str(ROOT))
    assert "<Result of pa6_bench: 101 samples to 1.01 s" in said


def test_one_module_does_not_load_the_api():
    code = "import sys, drill_twin.io.messages.topics; print(*sorted(sys.modules))"
    loaded = run("-c", code, PYTHONPATH=str(ROOT)).split()
    assert "drill_twin" in loaded
    assert not {"drill_twin.api", "numba", "matplotlib"} & set(loaded)


def test_every_name_of_the_api_is_there():
    from drill_twin import api

    assert set(dt.__all__) == {*api.__all__, "__version__"}
    assert all(getattr(dt, name) is getattr(api, name) for name in api.__all__)
    assert set(api.__all__) <= set(dir(dt))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        dt.nothing  # noqa: B018


@pytest.mark.long
def test_the_code_of_the_documentation_runs(tmp_path):
    blocks = re.findall(
        r"^```python\n(.*?)^```", (ROOT / "docs" / "api.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
    )
    assert len(blocks) == 6
    said = run("-c", "\n".join(blocks), cwd=tmp_path, PYTHONPATH=str(ROOT))
    assert said.splitlines()[-1].startswith("8.0")
    assert (tmp_path / "rod.yaml").exists()
