# SPDX-License-Identifier: Apache-2.0
"""The API loads lazily, and the examples run and pass a strict type check."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import drill_twin as dt

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"


def run(*command: str, cwd: Path = ROOT, **more: str) -> str:
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | more
    done = subprocess.run(
        [sys.executable, *command], cwd=cwd, env=environment, capture_output=True, text=True, timeout=900, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


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
