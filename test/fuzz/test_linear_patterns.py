# SPDX-License-Identifier: Apache-2.0
"""Texts of one repeat at every regular expression that sees text of others: the work grows as the text does.

A pattern is tried on two sizes, and the processor time of both is compared: eight times the text takes 64 times the
time where a pattern is quadratic.
"""

import importlib
import re
import time

import pytest

PATTERNS = {
    "drill_twin_rig.gateway.drillbotics": ("_STAMP", "_UNIT"), "drill_twin.scene.overrides": ("_INDEX",),
    "drill_twin.scene.lines": ("_LINE_BREAKS_OF_UNICODE",),
    "drill_twin.scene.well_plan.table": ("_BARE", "_DECIMAL_COMMA"),
    "drill_twin.core.units.parse": ("_QUANTITY",), "drill_twin.core.units.ranges": ("_COUNT",),
    "drill_twin.core.units.registry": ("_UNIT", "_POWER", "_COURSE", "_WORD"),
    "drill_twin.core.files.yaml_reader": ("_NUMBER",), "drill_twin.core.numerals": ("_NUMBER",),
    "drill_twin.io.messages.topics": ("_NAMED",),
}  # fmt: skip
"""Compiled patterns by module."""
MATCHED_WHOLE = {
    "drill_twin.core.units.parse._QUANTITY", "drill_twin.core.units.registry._UNIT",
    "drill_twin.core.files.yaml_reader._NUMBER", "drill_twin.core.numerals._NUMBER",
}  # fmt: skip
"""Those that are never searched for in a text; a search for them would take a time that grows as its square."""
INLINE = (
    r"(?m)^[ \t]*started: ['\"]?([0-9T:.+-]+)", r"\S{201,}", r"[-+\d.]+", r", at [^,\s]+:\d+",
    r"^(\[[^]]*\] ?)+: |, at \S+:\d+$", r"[^\w.-]+", r"(\d+)", r"_\d+$", r"(?i)(time|t_|t$)",
    r"(?:(\d{1,2})-(\d{1,2})-(\d{1,2}):)?([0-9a-f]{8,128}):([0-9a-f]{32,256})",
    r"(?i)(^|[^a-z])(wob|weight[ _-]?on[ _-]?bit)([^a-z]|$)", r"(?<=[.:]) ", r",\s*(?=[A-Za-z_][\w.]*=)",
)  # fmt: skip
"""Patterns where they are used."""
REPEATS = (
    " ", "\t", "\n", "0", "a", "A", "_", "-", ".", ",", ":", ";", "/", "^", "(", ")", "[", "]", "[]", "[] ", "{", "1 ",
    "1/", "1.", "1e", "a.", "a=", ", ", ", a", ", at ", "[a] ", "m^2", "deg", "\u00b5", "\u2028", "\u0661", "\0", "0-",
)  # fmt: skip
FAST = 0.01
"""Processor time of a text of 16 000 repeats that no timer tells from none [s]; a quadratic pattern takes a second."""
ALL = {
    **{f"{place}.{name}": getattr(importlib.import_module(place), name)
       for place, names in PATTERNS.items() for name in names},
    **{pattern: re.compile(pattern) for pattern in INLINE},
}  # fmt: skip


def work(name, text, tries=3):
    """Processor time of a match and, where it is used so, of a search for all places [s], the least of some tries."""
    pattern = ALL[name]
    least = float("inf")
    for _ in range(tries):
        begin = time.process_time()
        pattern.fullmatch(text)
        if name not in MATCHED_WHOLE:
            pattern.sub("", text)
        least = min(least, time.process_time() - begin)
    return least


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_the_work_of_a_pattern_grows_as_the_text(name):
    for repeat in REPEATS:
        for begin, end in (("", ""), ("1", "x"), ("a", "="), ("x [", "!")):
            small, large = (begin + repeat * count + end for count in (2000, 16_000))
            if work(name, large, tries=1) >= FAST:
                assert work(name, large) < 24.0 * work(name, small) + FAST, (repeat, begin, end)
