# SPDX-License-Identifier: Apache-2.0
"""The message on a name of a companion tells a package that is not installed from one installed without the name."""

from importlib.metadata import EntryPoint

import pytest

from drill_twin.cli import groups
from drill_twin.core import companions
from drill_twin.core.companions import not_installed


@pytest.mark.parametrize(
    ("installed", "words"), [("other", "which is not installed: pip"), ("rig", "installed without it: make setup")]
)
def test_the_message_tells_what_to_do(monkeypatch, installed, words):
    monkeypatch.setattr(companions, "entries", lambda _: ["an entry"])
    monkeypatch.setattr(companions, "package_of", lambda _: f"drill_twin_{installed}")
    said = str(not_installed("`drill-twin onset`", "drill_twin_rig"))
    assert said.startswith("`drill-twin onset` needs the package drill_twin_rig (rig software")
    assert words in said


@pytest.mark.parametrize(
    ("installed", "words"),
    [("rig", "Not installed; it is in the package drill_twin_studies."), ("studies", "Not registered; install")],
)
def test_the_help_tells_the_same(monkeypatch, installed, words):
    entry = EntryPoint("another", f"drill_twin_{installed}.cli:another", "drill_twin.commands")
    for module in (companions, groups):
        monkeypatch.setattr(module, "entries", lambda _: (entry,))
    assert groups._of_another("map").help.startswith(words)
