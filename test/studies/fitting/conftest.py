# SPDX-License-Identifier: Apache-2.0
"""The command line as a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[3]


@pytest.fixture
def process(tmp_path):
    def run(*arguments):
        path = os.pathsep.join(filter(None, (str(PACKAGE), os.environ.get("PYTHONPATH"))))
        return subprocess.run(
            [sys.executable, "-m", "drill_twin.cli", *map(str, arguments)],
            capture_output=True, text=True, timeout=300, check=False, cwd=tmp_path,
            env=dict(os.environ, PYTHONPATH=path, COLUMNS="160"),
        )  # fmt: skip

    return run
