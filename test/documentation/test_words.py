# SPDX-License-Identifier: Apache-2.0
"""The pages keep to the terms, sentences are short, figures have a source, the whole is short (docs/style.py)."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_keeps_to_the_terms_and_to_short_sentences(style, page):
    assert not list(style.faults(page.read_text("utf-8")))


def test_faults_are_seen_with_their_lines_and_not_in_code(style):
    page = f"# Title\n\nThe path of `mark-2`.\n\n```\nmark-2\n```\n* A marker.\n\n{'Word ' * (style.LONGEST + 1)}."
    assert [line for line, _ in style.faults(page)] == [8, 10]


def test_a_pronoun_for_a_noun_is_seen_over_the_end_of_a_line_and_not_in_code(style):
    page = "# Title\n\nIts limits are that\nof the scene. `those`\n\nOne of the limits holds."
    assert list(style.faults(page)) == [(3, "'that of': name the noun")]


@pytest.mark.parametrize(
    ("section", "right"),
    [
        ("It takes 0.4 s.", False),
        ("56 of 57 cases hold.", False),
        ("It takes 0.4 s (`make bench`).", True),
        ("<!-- no command: a definition --> A minute has 60 s.", True),
        ("Python 3.11 is needed.", True),
    ],
)
def test_a_figure_needs_its_source_in_its_section(style, section, right):
    assert (not list(style.faults(f"`make docs`\n\n## Section\n\n{section}\n"))) == right


def test_few_figures_have_no_command():
    texts = [page.read_text("utf-8") for page in PAGES]
    assert sum(text.count("<!-- no command: ") for text in texts) <= 4


@pytest.mark.parametrize("page", sorted((ROOT / "evidence" / "docs").glob("*.md")), ids=lambda page: page.name)
def test_lab_notes_name_the_command_that_printed_them(page):
    text = page.read_text("utf-8")
    assert re.search(r"drill-twin [a-z]|\bmake [a-z]|python -m", text)


def test_the_pages_have_at_most_27_500_words_written_by_hand(style):
    texts = [page.read_text("utf-8") for page in PAGES]
    assert sum(style.words(style.prose(text)) for text in texts if style.WRITTEN not in text) <= 27_500
