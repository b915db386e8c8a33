# SPDX-License-Identifier: Apache-2.0
"""A script that compiles says so on standard error, and Ctrl-C ends it and its child."""

import io
import os
import signal
import subprocess
import sys
from pathlib import Path

from drill_twin.api.simulation import CompileProgress

ROOT = Path(__file__).parents[2]
SCRIPT = "import drill_twin as dt; dt.Simulation('pa6_bench')"


def test_a_script_says_that_it_compiles_and_ends_with_ctrl_c(tmp_path):
    given = dict(os.environ, DRILL_TWIN_CACHE=str(tmp_path / "cache"), PYTHONPATH=str(ROOT))
    script = subprocess.Popen(
        [sys.executable, "-c", SCRIPT], env=given, cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    try:
        assert "compiling the effects of the scene, once for this set of effects" in script.stderr.readline()
        script.send_signal(signal.SIGINT)
        _, said = script.communicate(timeout=30)
    finally:
        script.kill()
        script.wait()
    assert script.returncode == -signal.SIGINT  # 130 in a shell
    assert said.rstrip().endswith("KeyboardInterrupt")
    assert not list((tmp_path / "cache").glob("*.machine_code"))


def test_a_terminal_gets_one_line_that_is_erased(monkeypatch):
    stream = io.StringIO()
    stream.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", stream)
    progress = CompileProgress()
    for text in ("compiling", "10 functions", "9"):
        progress(text)
    progress.end()
    assert stream.getvalue() == "\rcompiling\r10 functions\r9           \r            \r"
