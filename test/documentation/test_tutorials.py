# SPDX-License-Identifier: Apache-2.0
"""README, tutorials and how-to pages are followed as they stand: every command and snippet, in a clean folder.

Blocks `sh` are the commands of one shell, blocks `python` one script; a block `text` behind one is what it prints.
Blocks `console` set the machine up, as `make setup` does.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CUT = "====="


def blocks(page):
    """Kind and text of the blocks of a page, in order; the page has no others."""
    found = BLOCK.findall((DOCS / page).read_text("utf-8"))
    assert {kind for kind, _ in found} <= {"sh", "python", "text", "console", "yaml", "mermaid"}
    return found


def printed_after(page, kind):
    """Blocks of a kind, and the text that the page shows after each; None where it shows none."""
    found = blocks(page)
    following = [*found[1:], ("", "")]
    return [
        (text, shown if then == "text" else None)
        for (is_kind, text), (then, shown) in zip(found, following, strict=True)
        if is_kind == kind
    ]


def environment(**more):
    """The environment of a reader who has set the machine up."""
    found = {name: text for name, text in os.environ.items() if not name.startswith(("ROS_", "DRILL_TWIN"))}
    found |= {"PYTHONPATH": f"{ROOT}:{ROOT / 'evidence'}", "COLUMNS": "200", "MPLBACKEND": "Agg", **more}
    return found | {"PATH": f"{Path(sys.executable).parent}:{found['PATH']}"}


def run(arguments, folder, script, **more):
    ended = subprocess.run(
        arguments, input=script, cwd=folder, env=environment(**more), capture_output=True, text=True, timeout=500,
        check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "Traceback" not in ended.stderr
    return ended.stdout.split(f"{CUT}\n")


def follow_python(page, folder):
    """Run the snippets of a page as one script, and compare what each prints with what the page shows."""
    steps = printed_after(page, "python")
    said = run([sys.executable, "-"], folder, "".join(f"{text}\nprint({CUT!r})\n" for text, _ in steps))
    assert steps
    assert [shown or "" for _, shown in steps] == said[:-1]


def follow_shell(page, folder, domain=None):
    """Run the commands of a page in one shell; the lines that the page shows after some are among those printed."""
    steps = printed_after(page, "sh")
    first, *others = [f"{text}\necho {CUT}\n" for text, _ in steps]
    joined = f"export ROS_DOMAIN_ID={domain}\n" if domain is not None else ""
    said = run(["bash", "-c", f"set -euo pipefail\n{first}{joined}{''.join(others)}"], folder, "")
    for (_, shown), output in zip(steps, said, strict=False):
        lines = {" ".join(line.split()) for line in output.splitlines()}
        assert {" ".join(line.split()) for line in (shown or "").splitlines()} <= lines
    return said


def test_the_tutorial_in_python_prints_what_it_shows(tmp_path):
    follow_python("tutorial/python.md", tmp_path)
    assert {"bag_0", "displacement.png", "orbits.png"} <= {path.name for path in tmp_path.iterdir()}


def test_the_readme_prints_what_it_shows(tmp_path):
    follow_python("../README.md", tmp_path)


@pytest.mark.long
def test_the_tutorial_in_a_shell(tmp_path):
    from drill_twin.ros.deployment import DomainClaim

    claim = DomainClaim()  # the demo, which comes first, takes one by itself
    said = follow_shell("tutorial/ros.md", tmp_path, claim.domain)
    claim.release()
    assert "report.html" in said[1]
    assert (tmp_path / "own" / "bag_0" / "metadata.yaml").exists()
    assert (tmp_path / "own" / "report" / "report.html").exists()


def test_whirl_that_a_camera_has_seen(tmp_path):
    follow_python("howto/measure_whirl.md", tmp_path)


@pytest.mark.long
def test_a_lab_rig_and_its_fit(tmp_path):
    follow_shell("howto/lab_rig.md", tmp_path)
    assert {"modes.png", "response.png"} <= {path.name for path in (tmp_path / "modes").iterdir()}
    follow_python("howto/lab_rig.md", tmp_path)


@pytest.mark.long
def test_a_scene_of_ones_own(tmp_path):
    follow_shell("howto/own_scene.md", tmp_path)


@pytest.mark.long
def test_a_scene_from_a_well_plan(tmp_path):
    follow_shell("howto/well_plan.md", tmp_path)
    assert (tmp_path / "out" / "compare" / "compare.html").exists()


@pytest.mark.long
def test_a_scene_with_sensors(tmp_path):
    assert "first at middle" in follow_shell("sensors.md", tmp_path)[0]


@pytest.mark.long
def test_a_bag_simulated_again(tmp_path):
    follow_python("howto/replay_a_bag.md", tmp_path)
