# SPDX-License-Identifier: Apache-2.0
"""Style of the pages: one term for one thing, nouns instead of pronouns, short sentences, figures with a source.

`make docs` warns of faults. The rule for pronouns holds in docstrings and comments too.
"""

import io
import re
import tokenize
from collections.abc import Iterator

INSTEAD = {
    r"mark-\d|\bmarkers?\b": "mark_1, mark_2 ..., or mark",
    r"\btexts\b": "text, or strings",
    r"\b(?:one|a|line|lines|runs) a (?:core|terminal|coefficient|fit)\b": "one for each, or per",
    r"\b(?:leaves?|left|leaving) out\b": "omit",
    r"\b(?:goes|going) on\b|\bwent on\b": "resume, or continue",
    r"\bare told\b|\bis told\b|\btold (?:in|by|of)\b": "reported",
    r"\bin space\b": "spatial, or in three dimensions",
    r"\b(?:the house|rooms?)\b": "package",
    r"\breal-time factor\b|\bRTF\b|\btimes real time\b": "× real time",
    r"\breverse whirl\b": "backward whirl",
    r"\bprecession\b": "whirl frequency, or whirl speed",
    r"\bcritical time\b": "onset",
    r"\bpresets?\b": "scene",
    r"\b(?:live|watch) page\b": "dashboard",
    r"\br/min\b": "rpm",
    r"\bpeers?\b": "other tools",
    r"\b(?:simply|obviously|easily|of course)\b": "nothing",
    r"\b(?:lever|price tag|pull in|lab notebook|comes? by mail)\b": "the plain word instead of a metaphor",
}
"""Pattern of each word that the pages do not use, and what to write instead."""
PRONOUN = re.compile(
    r"\b(?:those|that\s+of|that\s+which|ones?\s+(?:that|which|whose)|ones\s+of|the\s+former|the\s+latter|thereof|therein)\b",
    re.IGNORECASE,
)
"""Pronouns that stand for a noun; `one of` passes, as the noun of the set follows it."""
WRITTEN = "<!-- Written by `drill-twin"
"""Mark of a page that a command writes as a whole."""
LONGEST = 32
"""Words of the longest sentence."""

_SKIPPED = re.compile(
    r"^<!-- printed: (\w+) -->\n.*?^<!-- end: \1 -->$|^<!-- output of .*?^<!-- end of output -->$|^[ ]*```.*?^[ ]*```$"
    r"|<!--.*?-->|\$\$.*?\$\$|\]\([^)]*\)|`[^`\n]*`|\$[^$\n]+\$",
    re.MULTILINE | re.DOTALL,
)
_PRINTED = re.compile(r"^(<!-- printed: (\w+) -->)\n.*?^<!-- end: \2 -->$", re.MULTILINE | re.DOTALL)
_FIGURE = re.compile(
    r"\d ?%|\b\d[\d,]* of (?:the )?\d|\de-\d|(?<![\d.])\d[\d.,]* ?(?:ns|ms|µs|s|min|h|GB|MB|Hz|N|kN|N m|kN m|mm|m)\b"
    r"|\d (?:times|× real)|(?<![\d.])\d+\.\d+(?![\d.])"
)
_NO_FIGURE = re.compile(r"Python 3\.\d+(?: or 3\.\d+)?|doi 10\S+")
_SOURCE = re.compile(
    r"drill-twin [a-z]|\bmake [a-z]|python -m|\bros2 [a-z]|\btest_\w+\.py"
    r"|\b(?:test|evidence|drill_twin|companions|config|docs)/[\w/]+\.(?:py|md|yaml)"
    r"|<!-- (?:printed|output of|no command):? .*?-->"
)
_BLOCK = re.compile(r"\n\s*\n|\n(?=\s*(?:[*|#>:]|\d\.|- ))")
_SENTENCE = re.compile(r"(?<=[.!?:])\s+(?=[^\sa-z])")


def prose(page: str) -> str:
    """Text of a page on the same lines, without code, formulas, targets of links and what a command printed."""
    return _SKIPPED.sub(lambda found: "\n" * found[0].count("\n") or ("]" if found[0][0] == "]" else "CODE"), page)


def words(text: str) -> int:
    """Number of words: what has a letter or a digit."""
    return sum(any(sign.isalnum() for sign in word) for word in text.split())


def pronouns(text: str) -> Iterator[tuple[int, str]]:
    """Number of the line of each pronoun that stands for a noun, and what to do, in a text without code."""
    for found in PRONOUN.finditer(text):
        yield text.count("\n", 0, found.start()) + 1, f"{' '.join(found[0].split())!r}: name the noun"


def commentary(source: str) -> str:
    """Comments and docstrings of a Python source on the same lines; a full stop stands for a line of code."""
    lines = ["."] * (source.count("\n") + 1)
    begins = True
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT or (begins and token.type == tokenize.STRING):
            lines[token.start[0] - 1 : token.end[0]] = [part.strip("# ") for part in token.string.split("\n")]
        if token.type not in {tokenize.COMMENT, tokenize.NL}:
            begins = token.type in {tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    return "\n".join(lines)


def faults(page: str) -> Iterator[tuple[int, str]]:
    """Number of the line and description of each word to avoid, pronoun, long sentence and figure without source."""
    yield from _without_source(page)
    text = prose(page)
    yield from pronouns(text)
    for pattern, better in INSTEAD.items():
        for found in re.finditer(pattern, text, re.IGNORECASE):
            yield text.count("\n", 0, found.start()) + 1, f"{found[0]!r}: write {better}"
    start = 0
    for end in (*(found.end() for found in _BLOCK.finditer(text)), len(text)):
        block, line = text[start:end], text.count("\n", 0, start) + 1
        start = end
        if block.lstrip().startswith(("|", "#")):
            continue
        for sentence in _SENTENCE.split(" ".join(block.split())):
            if words(sentence) > LONGEST:
                yield line, f"a sentence of {words(sentence)} words, at most {LONGEST}: {sentence[:60]} ..."


def _without_source(page: str) -> Iterator[tuple[int, str]]:
    """Sections with a figure, and neither the command that prints it nor the file of code, test or scene that has it.

    A figure of neither kind, as of a definition, is let through by a comment `<!-- no command: REASON -->`.
    """
    if WRITTEN in page:
        return
    line, written = 1, _PRINTED.sub(lambda part: part[1] + "\n" * part[0].count("\n"), page)
    for section in re.split(r"^(?=#+ )", written, flags=re.MULTILINE):
        found = _FIGURE.search(_NO_FIGURE.sub("", prose(section)))
        if found and not _SOURCE.search(section):
            yield line, f"a figure without the command or file that it comes from: {found[0]!r}"
        line += section.count("\n")
