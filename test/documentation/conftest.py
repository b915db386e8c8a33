# SPDX-License-Identifier: Apache-2.0
"""The rules of style, `docs/style.py`, for tests of pages and of docstrings."""

import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="session")
def style():
    sys.path.insert(0, str(DOCS))
    try:
        import style
    finally:
        sys.path.remove(str(DOCS))
    return style
