# SPDX-License-Identifier: Apache-2.0
"""Write what the code and the evidence print into the pages that show it: `python docs/print_reference.py`.

A part that is committed stands between `<!-- printed: NAME -->` and `<!-- end: NAME -->`; one without an end is printed
while the site is built.
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import _printed  # noqa: E402 - the two paths above come first

COMMITTED = re.compile(r"^(<!-- printed: (\w+) -->\n).*?^(<!-- end: \2 -->)$", re.MULTILINE | re.DOTALL)


def printed_anew(page: str) -> str:
    """Text of a page with each committed part as the code prints it now."""
    return COMMITTED.sub(lambda found: f"{found[1]}\n{_printed.PAGES[found[2]]()}\n{found[3]}", page)


if __name__ == "__main__":
    for path in (HERE.parent / "README.md", *sorted(HERE.rglob("*.md"))):
        text = path.read_text("utf-8")
        path.write_text(printed_anew(text), "utf-8")
