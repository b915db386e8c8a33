# SPDX-License-Identifier: Apache-2.0
"""Files of signals of the gateway with odd content are read, or refused in a sentence."""

import copy
import os
import random

import pytest
import yaml

from drill_twin.core.errors import DrillTwinError
from drill_twin_rig.gateway.signals import read_signals, signals_path

INPUTS = int(os.environ.get("DRILL_TWIN_FUZZ", "3000")) // 10
ODD = [None, True, "", " ", "x" * 5000, "\u0661", "nan", float("nan"), float("inf"), 1e308, -1, 0, [], [1], {},
       {"a": 1}, "N m", "\x00", "é", 2**70, "1_0", [[[]]], {1: 2}]  # fmt: skip
SECTIONS = ["show", "command", "follow", "measure", "x", 1, None, True]
FIELDS = ["value", "unit", "low", "high", "server", "node", "x"]


def _damaged(content, chance):
    """A copy of the content with one to three odd values or names."""
    damaged = copy.deepcopy(content)
    for _ in range(chance.randint(1, 3)):
        section = chance.choice(list(damaged))
        rows, how = damaged[section], chance.random()
        if how < 0.15 or not (isinstance(rows, dict) and rows):
            damaged[chance.choice(SECTIONS)] = chance.choice(ODD)
        elif how < 0.4:
            rows[chance.choice(list(rows))] = chance.choice(ODD)
        elif how < 0.8 and isinstance(row := rows[chance.choice(list(rows))], dict):
            row[chance.choice(FIELDS)] = chance.choice(ODD)
        else:
            rows[chance.choice([1, None, "", "a" * 300, "x\ny"])] = chance.choice(ODD)
    return damaged


@pytest.mark.parametrize("seed", range(4))
def test_odd_signals_are_read_or_refused(tmp_path, seed):
    content, chance = yaml.safe_load(signals_path("dwis").read_text("utf-8")), random.Random(seed)
    path, refusals = tmp_path / "signals.yaml", []
    for _ in range(INPUTS // 4):
        path.write_text(yaml.safe_dump(_damaged(content, chance), allow_unicode=True), "utf-8")
        try:
            read_signals(path)
        except DrillTwinError as error:
            refusals.append(len(str(error)))
    assert len(refusals) > INPUTS // 8
    assert max(refusals) < 2000


@pytest.mark.parametrize(
    "raw",
    [b"[" * 100_000, b"{" * 100_000, b"\x00", b"\xff\xfe", b"", b"show: *a", b"show: &a {b: *a}",
     b"!!python/object/apply:os.system ['ls']", b"show: 1\n---\nshow: 2\n",
     b"show:\n  A: {value: weight_on_bit}\n  A: {value: weight_on_bit}\n"],
)  # fmt: skip
def test_a_file_that_is_none_of_signals_is_refused(tmp_path, raw):
    path = tmp_path / "signals.yaml"
    path.write_bytes(raw)
    with pytest.raises(DrillTwinError, match=r"signals\.yaml"):
        read_signals(path)
