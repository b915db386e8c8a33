# SPDX-License-Identifier: Apache-2.0
"""The notebooks run, and print what they hold."""

import json
import re

import pytest
from test_documentation_paths import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def printed(cell):
    """Words and numbers that a cell prints; other processors round otherwise."""
    text = "".join("".join(one["text"]) for one in cell.get("outputs", []) if "text" in one)
    number = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
    return re.sub(number, "#", text).split(), [float(found) for found in re.findall(number, text)]


@pytest.mark.long
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs_and_prints_what_it_holds(file, monkeypatch):
    monkeypatch.syspath_prepend(str(file.parent))
    from run import executed

    held = json.loads(file.read_text("utf-8"))
    done = executed(json.loads(file.read_text("utf-8")))
    for before, after in zip(held["cells"], done["cells"], strict=True):
        assert [one["output_type"] for one in after.get("outputs", [])] == [
            one["output_type"] for one in before.get("outputs", [])
        ]
        (words, numbers), (wanted, close) = printed(after), printed(before)
        assert words == wanted
        assert numbers == pytest.approx(close, rel=0.1)
    assert len(file.read_bytes()) < 200_000
