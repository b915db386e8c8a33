# SPDX-License-Identifier: Apache-2.0
"""Docstrings open with a noun or an imperative, not with a question word."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
QUESTION = re.compile(r'^\s*r?"""(?:How|What|When|Where|Whether|Which|Who|Whose|Why)\b', re.MULTILINE)


def test_no_docstring_opens_with_a_question_word():
    sources = [
        path
        for room in ("drill_twin", "companions/*/drill_twin_*", "evidence/drill_twin_evidence", "docs", "config")
        for folder in ROOT.glob(room)
        for path in folder.rglob("*.py")
    ]
    assert len(sources) > 500
    found = [f"{path.relative_to(ROOT)}: {match[0].strip()}" for path in sources
             for match in QUESTION.finditer(path.read_text("utf-8"))]  # fmt: skip
    assert not found, "write a noun or an imperative"


def test_the_question_words_are_seen():
    assert QUESTION.search('def f():\n    """Whether it is so."""')
    assert not QUESTION.search('"""Whatever is given."""')
