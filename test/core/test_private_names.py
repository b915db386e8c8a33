# SPDX-License-Identifier: Apache-2.0
"""Private names of other libraries that the package uses: each is listed in its page, and is there."""

import importlib
import inspect
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| `([\w.]+):([\w.]+)` \| `([^`]+)`.* \| `((?:test|companions)/[^`]+)` \|$", re.MULTILINE)
ROWS = ROW.findall((ROOT / "evidence" / "docs" / "private_compiler.md").read_text("utf-8"))


def test_the_page_has_a_table():
    assert len(ROWS) > 30


@pytest.mark.parametrize(("module", "path", "file", "test"), ROWS, ids=[f"{row[0]}:{row[1]}" for row in ROWS])
def test_a_private_name_is_there(module, path, file, test):
    if module.startswith("rclpy"):
        pytest.importorskip("rclpy")
    found = importlib.import_module(module)
    *outer, name = path.split(".")
    for one in outer:
        found = getattr(found, one)
    if inspect.isclass(found):
        written = [one for one in found.__mro__ if one.__module__ not in {"builtins", "_dispatcher"}]  # not in C
        sources = "".join(map(inspect.getsource, written))
        assert hasattr(found, name) or re.search(rf"\bself\.{name}\b", sources)
    else:
        assert hasattr(found, name)
    assert name.lstrip("_") in (ROOT / file).read_text("utf-8")
    assert (ROOT / test).is_file()


def test_every_private_name_that_is_used_is_listed():
    listed = {path.lstrip("_") for _, whole, _, _ in ROWS for path in whole.split(".")}
    used = set()
    for file in (
        file
        for room in ("drill_twin", "companions/*/drill_twin_*")
        for folder in ROOT.glob(room)
        for file in folder.rglob("*.py")
    ):
        for line in file.read_text("utf-8").splitlines():
            if "SLF001" in line:
                code = line.partition("#")[0]
                used |= {name.lstrip("_") for name in re.findall(r"\w\.(?:_Writer_)?(_+[a-z]\w*)", code)}
    assert used
    assert not used - listed
