# SPDX-License-Identifier: Apache-2.0
"""Modules planted in the working folder, beside everything that is read, are not run."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from drill_twin.core.process import child_environment

ROOT = Path(__file__).parents[2]
NAMES = (
    "numpy", "json", "scipy", "io", "resource", "csv", "yaml", "pickle", "multiprocessing", "struct", "zlib", "rclpy",
    "numba", "drill_twin", "sitecustomize", "usercustomize", "re", "encodings",
)  # fmt: skip
READ = """
from pathlib import Path
from drill_twin.scene.records import read_columns
print(sorted(read_columns(Path("table.mat"))))
"""
POOL = """
import math
from drill_twin.studies.pool import process_pool
if __name__ == "__main__":
    with process_pool(1) as pool:
        print(pool.submit(math.sqrt, 4.0).result())
"""
NODE = f"""
import os
import sys
from pathlib import Path
sys.path.insert(0, {str(ROOT / "evidence")!r})
from drill_twin_evidence.benchmarks.processes import Child
child = Child("no_such_node", {{}}, os.environ, Path("log"))
print(child.wait(60.0), child.log_tail())
"""


@pytest.fixture
def planted(tmp_path):
    """A folder with a table and, beside it, modules that leave a mark when they are run."""
    time = np.arange(0.0, 2.0, 0.02)
    savemat(tmp_path / "table.mat", {"time": time, "wob": 20.0 + time, "rpm": 60.0 + time})
    code = f"open({str(tmp_path / 'ran')!r}, 'a').write(__name__ + ' ')\n"
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(code, "utf-8")
    (tmp_path / "drill_twin").mkdir()
    (tmp_path / "drill_twin" / "__init__.py").write_text(code, "utf-8")
    return tmp_path


@pytest.mark.parametrize("python_path", [str(ROOT), f"{ROOT}:", f":.:{ROOT}"])
@pytest.mark.parametrize(
    ("script", "said"), [(READ, "['rpm', 'time', 'wob']"), (POOL, "2.0"), (NODE, "found 'no_such")]
)
def test_no_child_runs_what_lies_in_the_working_folder(script, said, python_path, planted, tmp_path_factory):
    file = tmp_path_factory.mktemp("script") / "main.py"
    # The parent is started as the console script is, without the working folder; its children get the rest.
    set_path = f"import os; os.environ['PYTHONPATH'] = {python_path!r}\n"
    file.write_text(set_path + script, "utf-8")
    environment = dict(os.environ, PYTHONPATH=str(ROOT))
    done = subprocess.run(
        [sys.executable, str(file)],
        cwd=planted,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert not (planted / "ran").exists(), (planted / "ran").read_text("utf-8")
    assert said in done.stdout, (done.stdout, done.stderr[-2000:])


def test_children_import_this_copy_of_the_package():
    found = child_environment({"PYTHONPATH": f"relative::{os.sep}absolute"})
    assert found["PYTHONPATH"].split(os.pathsep)[-1] == f"{os.sep}absolute"
    assert "relative" not in found["PYTHONPATH"]
    assert found["PYTHONSAFEPATH"] == "1"
