# SPDX-License-Identifier: Apache-2.0
"""The pages keep to the terms, their sentences are short, and the whole can be read in a day (docs/style.py)."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
BY_A_COMMAND = "<!-- Written by `drill-twin"


@pytest.fixture(scope="module")
def style():
    sys.path.insert(0, str(DOCS))
    try:
        import style
    finally:
        sys.path.remove(str(DOCS))
    return style


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_keeps_to_the_terms_and_to_short_sentences(style, page):
    assert not list(style.faults(page.read_text("utf-8")))


def test_faults_are_seen_with_their_lines_and_not_in_code(style):
    page = f"# Title\n\nThe path of `mark-2`.\n\n```\nmark-2\n```\n* A marker.\n\n{'Word ' * (style.LONGEST + 1)}."
    assert [line for line, _ in style.faults(page)] == [8, 10]


def test_the_pages_have_at_most_26_000_words_written_by_hand(style):
    texts = [page.read_text("utf-8") for page in PAGES]
    assert sum(style.words(style.prose(text)) for text in texts if BY_A_COMMAND not in text) <= 26_000
