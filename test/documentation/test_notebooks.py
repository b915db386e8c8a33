# SPDX-License-Identifier: Apache-2.0
"""The notebooks run, and print what they hold."""

import json

import pytest
from test_documentation_paths import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


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
        printed = [one["text"] for one in after.get("outputs", []) if "text" in one]
        assert printed == [one["text"] for one in before.get("outputs", []) if "text" in one]
    assert len(file.read_bytes()) < 200_000
