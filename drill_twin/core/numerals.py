# SPDX-License-Identifier: Apache-2.0
"""Numbers in texts from outside: one reader for records, rigs, scenes, options and the environment.

Python's `float` and `int` also take 1_0 as 10, digits of other scripts, blanks around, `inf` and `nan`, and a whole
number of any length; what writes such a text does not mean that.
"""

import re

NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
"""Regular expression of a number, for `re.ASCII`."""
_NUMBER = re.compile(NUMBER, re.ASCII)
_MOST_DIGITS = 18  # of a whole number: below 2**63


def number(text: str) -> float | None:
    """Number of a text, infinite where a double cannot hold it; None if the text is no number."""
    return float(text) if _NUMBER.fullmatch(text) else None


def whole_number(text: str) -> int | None:
    """Number of a text of at most 18 digits; None if the text is no number."""
    return int(text) if text.isascii() and text.isdigit() and len(text) <= _MOST_DIGITS else None
