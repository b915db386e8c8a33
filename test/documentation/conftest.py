# SPDX-License-Identifier: Apache-2.0
"""Modules beside the pages: the rules of style, `docs/style.py`, and the printed reference, `docs/_printed`."""

import sys
from importlib import import_module
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def _module(name):
    """A module beside the pages."""
    sys.path.insert(0, str(DOCS))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(DOCS))


@pytest.fixture(scope="session")
def style():
    return _module("style")


@pytest.fixture(scope="session")
def printed():
    """Function that prints a part of the reference, by name."""
    pages = _module("_printed").PAGES
    return lambda name: pages[name]()
