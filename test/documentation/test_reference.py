# SPDX-License-Identifier: Apache-2.0
"""The reference that is printed from the code has everything, and the table of diagnostics what a run reports."""

import re
import sys
from importlib import metadata
from pathlib import Path

import pytest

import drill_twin as dt
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.topics import DIAGNOSTICS, OF_SUBS, TOPICS
from drill_twin.physics.effects import EFFECTS

DOCS = Path(__file__).parents[2] / "docs"


def _pinned():
    """Whether the installed distributions are those of the committed table of licences."""
    pins = (DOCS.parent / "constraints.txt").read_text("utf-8").splitlines()
    return sys.version_info[:2] == (3, 11) and f"numpy=={metadata.version('numpy')}" in pins


def _headings(text):
    return re.findall(r"^## (.*)$", text, re.MULTILINE)


def _keys(text):
    return set(re.findall(r"^\| `([^`]*)`", text, re.MULTILINE))


@pytest.mark.slow
def test_every_part_is_on_a_page_and_committed_ones_are_those_of_the_code(printed):
    pages = [page.read_text("utf-8") for page in (DOCS.parent / "README.md", *DOCS.rglob("*.md"))]
    used = {name for page in pages for name in re.findall(r"^<!-- printed: (\w+)", page, re.MULTILINE)}
    assert used == {
        *("api", "commands", "effect_keys", "nodes", "scene_keys", "topics", "topics_quality"),
        *("api_names", "exact_checks", "hard_scenes", "licences", "signals", "summary_keys"),
    }
    committed = [
        found
        for page in pages
        for found in re.findall(r"^<!-- printed: (\w+) -->\n(.*?)<!-- end: \1 -->$", page, re.MULTILINE | re.DOTALL)
    ]
    assert {name for name, _ in committed} == used - {"api"}  # whose docstrings the site shows
    for name, text in committed:
        if name == "licences" and not _pinned():
            continue
        assert text.strip() == printed(name).strip(), f"{name}: python docs/print_reference.py writes it"


def test_topics_and_effects(printed):
    assert _keys(printed("topics")) == _keys(printed("topics_quality")) == TOPICS.keys() | {row.name for row in OF_SUBS}
    text = printed("effect_keys")
    assert _headings(text) == list(EFFECTS)
    assert _keys(text) == {key for config in EFFECTS.values() for key in config.model_fields}
    assert re.search(r"\| `reference_speed` \| .*0\.1 m/s.* Range: above 0 m/s and at most 100 m/s", text)


def test_scene_keys_are_those_of_the_models(printed):
    text = printed("scene_keys")
    scene = dt.load_scene("pa6_bench")
    blocks = {"string": scene.string, "hole": scene.hole, "rig": scene.rig, "numerics": scene.numerics,
              "string.sections[k]": scene.string.sections[0], "rig.weight_on_bit": scene.rig.weight_on_bit}  # fmt: skip
    assert blocks.keys() <= set(_headings(text))
    for name, block in blocks.items():
        table = text.partition(f"## {name}\n")[2].partition("\n## ")[0]
        assert _keys(table) == set(type(block).model_fields)


def test_commands_and_parameters(printed):
    from drill_twin.cli.app import commands
    from drill_twin.ros import entry_points
    from drill_twin.ros.composed_twin import PARAMETERS

    assert _headings(printed("commands")) == [name for name, _ in commands()]
    text = printed("nodes")
    assert _headings(text) == [*entry_points.node_names(), "twin"]
    wanted = {item.name for name in entry_points.node_names() for item in entry_points.load(name).PARAMETERS}
    assert _keys(text) == wanted | {item.name for item in PARAMETERS}


def test_names_of_the_python_api(printed):
    text = printed("api")
    assert set(re.findall(r":: drill_twin\.(\w+)$", text, re.MULTILINE)) == set(dt.__all__) - {"__version__"}
    names = re.findall(r"^\| `(\w+)", printed("api_names"), re.MULTILINE)
    assert sorted(names) == sorted(set(dt.__all__) - {"__version__"})
    headings = _headings(text)
    assert headings[:4] == ["Scenes", "Runs", "Results", "Analysis"]
    assert headings[-1] == "Errors"


def test_the_table_of_diagnostics_has_what_a_run_reports():
    page = (DOCS / "reference" / "diagnostics.md").read_text("utf-8")
    names = {name for row in re.findall(r"^\| (`.*?) \|", page, re.MULTILINE) for name in re.findall(r"`([^`]+)`", row)}
    listed = {name for name in names if not name.endswith(("...", "EFFECT", "INPUT", "KIND", "TOPIC"))}
    result = dt.Simulation("pa6_bench").run(duration=0.1)
    reported = {
        key
        for _, _, raw in result.recording.bag.messages([DIAGNOSTICS])
        for status in decode_diagnostics(raw)[1]
        for key in status.values
    }
    assert reported
    assert {key for key in reported if not key.startswith("energy_")} <= listed
    sources = "".join(
        file.read_text() for room in ("drill_twin", "companions") for file in (DOCS.parent / room).rglob("*.py")
    )
    assert not [name for name in listed if f'"{name}"' not in sources]
