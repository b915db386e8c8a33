# SPDX-License-Identifier: Apache-2.0
"""Docstrings open with a noun or an imperative, and name their nouns, as comments do (docs/style.py)."""

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


def test_docstrings_and_comments_name_their_nouns(style):
    found = []
    for folder in [ROOT / "drill_twin", *ROOT.glob("companions/*/drill_twin_*")]:
        for path in sorted(folder.rglob("*.py")):
            source = path.read_text("utf-8")
            if style.PRONOUN.search(source.replace("#", " ")):
                faults = style.pronouns(style.commentary(source))
                found += [f"{path.relative_to(ROOT)}:{line}: {fault}" for line, fault in faults]
    assert not found, "\n".join(["name the noun", *found])


def test_pronouns_are_seen_in_docstrings_and_comments_and_not_in_messages(style):
    source = '''"""Those of a module."""
LIMIT = 1.0
"""Limit, that
of the scene."""
# The first is that
# of the scene, the second
raise ValueError("those of a message")  # thereof
f(
    "those",
)
'''
    assert [line for line, _ in style.pronouns(style.commentary(source))] == [1, 3, 5, 7]
