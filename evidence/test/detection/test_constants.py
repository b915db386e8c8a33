# SPDX-License-Identifier: Apache-2.0
"""Numeric constants of the whirl analysis: found wherever they stand, and varied in place.

`.ci/ratchet.py` holds how many have no ground.
"""

import ast

import pytest

from drill_twin_evidence.detection.constants.__main__ import NOTHING, WHIRL, change, main, table
from drill_twin_evidence.detection.constants.ground import Ground, stated
from drill_twin_evidence.detection.constants.literals import CHOICES, Use, counts, literals
from drill_twin_evidence.detection.constants.outcome import Outcome
from drill_twin_evidence.detection.constants.variation import Row, edited

TRICKY = '''\
"""The ä in this line moves bytes."""
import math, enum
import numpy as np

LIMIT = -3.5
"""It follows from the formula."""
ANGLE, TURN = math.radians(30.0), 4.0 * math.pi
TABLE = {"a": 0.25, "b": (7, -8)}
"""Chosen, not measured."""
A, B, C = range(3)
BARE = 5  # twice the 2.5 of Student


class Code(enum.IntEnum):
    FIRST = 9


class Holder:
    size: int = 11


@strict_kernel
def kernel(x, y=0.3, *, most=40):
    """Mean over 16 bins, so that noise is small."""
    z = np.zeros((3, 6))
    if x[5] > 0.7 and y < -0.2:
        return x * 1e-9 + 1j + max(y, 1e-300) + 16 * 0 + 1 + 2.0 + 0x10
    return f"é {100 * x:.3f}", (lambda: 12), "ä", 13 if True else 2


class Other:
    def method(self):
        inside = 6.5
        return inside
'''


@pytest.fixture
def found(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "tricky.py").write_text(TRICKY, "utf-8")
    return literals(tmp_path)


def test_literals_are_found_wherever_they_stand(found):
    assert {(one.name, one.value) for one in found if one.use is Use.CONSTANT} == {
        ("LIMIT", -3.5), ("ANGLE, TURN", 30.0), ("ANGLE, TURN", 4.0), ("TABLE", 0.25), ("TABLE", 7), ("TABLE", -8),
        ("BARE", 5), ("Holder.size", 11),
    }  # fmt: skip
    assert sorted(one.value for one in found if one.use is Use.FACTOR) == [-0.2, 0.3, 0.7, 6.5, 12, 13, 16, 16, 40]
    others = {(one.use, one.value) for one in found if one.use not in CHOICES}
    assert others == {
        (Use.CODE, 3), (Use.CODE, 9), (Use.SHAPE, 3), (Use.SHAPE, 6), (Use.INDEX, 5), (Use.UNIT, 1e-9), (Use.UNIT, 1j),
        (Use.GUARD, 1e-300), (Use.TEXT, 100),
    }  # fmt: skip
    numbers = [n.value for n in ast.walk(ast.parse(TRICKY)) if isinstance(n, ast.Constant)]
    assert len(found) == sum(type(n) in {int, float, complex} and n not in {0, 1, 2} for n in numbers)


def test_the_ground_is_that_of_its_own_docstring_or_comment(found):
    grounds = {(one.name, one.value): one.ground for one in found}
    assert grounds["LIMIT", -3.5] is Ground.DERIVED
    assert grounds["ANGLE, TURN", 30.0] is Ground.NONE
    assert grounds["TABLE", -8] is Ground.CHOSEN
    assert grounds["BARE", 5] is Ground.SOURCE
    assert grounds["kernel", 16] is Ground.DERIVED  # its docstring holds the number
    assert grounds["kernel", 0.7] is Ground.NONE
    assert grounds["Other.method", 6.5] is Ground.NONE


def test_not_measured_is_not_measured():
    assert stated("Most bins; chosen, not measured.") is Ground.CHOSEN
    assert stated("No such threshold was measured by itself.") is Ground.CHOSEN
    assert stated("Found by `make sub-onsets`.") is Ground.MEASURED
    assert stated("Longest window [s].") is Ground.NONE


def test_a_literal_is_varied_in_its_place_alone(found):
    for one in found:
        if one.use not in CHOICES:
            continue
        changed = edited(TRICKY, one, 2.0)
        assert len(changed.splitlines()) == len(TRICKY.splitlines())
        differing = [
            k for k, (a, b) in enumerate(zip(TRICKY.splitlines(), changed.splitlines(), strict=True), 1) if a != b
        ]
        assert differing == [one.line]
        before, after = ([n.value for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Constant)]
                         for text in (TRICKY, changed))  # fmt: skip
        different = [(a, b) for a, b in zip(before, after, strict=True) if a != b]
        assert different == [(abs(one.value), 2 * abs(one.value))]
    whole = next(one for one in found if one.name == "BARE")
    assert [whole.times(factor) for factor in (0.5, 2.0)] == ["2", "10"]
    with pytest.raises(ValueError, match="expected 5, found"):
        edited(TRICKY.replace("BARE", "LONGER"), whole, 2.0)


def test_what_changes_nothing_is_named(found):
    base = Outcome(half=3, onsets=4, missed=0, false=0, f1=0.9, marks=0.8, digests={"marks": "a", "bit": "b"})
    moved = Outcome(half=2, onsets=4, missed=1, false=0, f1=0.8, marks=0.8, digests={"marks": "c", "bit": "b"})
    limit, bare = (next(one for one in found if one.name == name) for name in ("LIMIT", "BARE"))
    rows = [Row(key="as it is", factor=1.0, outcome=base, error="")]
    rows += [Row(key=limit.key, factor=factor, outcome=base, error="") for factor in (0.5, 2.0)]
    rows += [
        Row(key=bare.key, factor=0.5, outcome=moved, error=""),
        Row(key=bare.key, factor=2.0, outcome=None, error="x"),
    ]
    one, other = table([limit, bare], rows)
    assert one["verdict"] == NOTHING
    assert other["verdict"] == ""
    assert [other[f"{name} x0.5"] for name in ("half", "missed", "f1", "changes")] == [-1, 1, -0.1, "marks"]
    assert other["changes x2"] == "fails: x"
    assert table([limit, bare], rows[:2]) == []  # a literal is in the table once it has both
    assert change(None, base) == {}


def test_the_count_is_printed(capsys):
    main([])
    printed = capsys.readouterr().out
    assert f"| all | {counts(literals(WHIRL))['all']} |" in printed
    with pytest.raises(SystemExit, match="2"):
        main(["journal.jsonl", "--only", "nowhere.py"])


@pytest.mark.long
def test_a_constant_is_varied(tmp_path):
    main([str(tmp_path / "journal.jsonl"), "--only", "history.py", "--first", "1", "--each", "1"])
    text = (tmp_path / "journal.csv").read_text("utf-8")
    assert "history.py" in text
    assert len(text.splitlines()) == 2
