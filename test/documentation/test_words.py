# SPDX-License-Identifier: Apache-2.0
"""One term for one thing: words that the pages do not use, each with the one that they use."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
INSTEAD = {
    r"mark-\d": "mark_1, mark_2 ...",
    r"\btexts\b": "text",
    r"\bone a core\b": "one per core",
    r"\bleave out\b": "omit",
    r"\b(?:the house|rooms?)\b": "package",
    r"\breal-time factor\b": "multiple of real time",
}
"""Pattern of each word, and what to write instead."""
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *(page for page in (ROOT / "docs").rglob("*.md") if "<!-- printed" not in page.read_text("utf-8")),
]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_keeps_to_the_terms(page):
    text = page.read_text("utf-8")
    found = [f"{word[0]!r}: write {better}" for pattern, better in INSTEAD.items()
             for word in re.finditer(pattern, text)]  # fmt: skip
    assert not found


def test_a_word_is_seen():
    assert any(re.search(pattern, "Path of mark-2") for pattern in INSTEAD)
