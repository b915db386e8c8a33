# SPDX-License-Identifier: Apache-2.0
"""The pictures of the README and the introduction are drawn from what runs, and the committed ones are small."""

import re
from pathlib import Path

import pytest

from drill_twin_evidence.pictures import sketches
from drill_twin_evidence.pictures.__main__ import PICTURES

FIGURES = Path(__file__).parents[3] / "docs" / "figures"


@pytest.mark.parametrize(("draw", "said"), [(sketches.draw_frames, "clearance"), (sketches.draw_nodes, "/rig/command")])
def test_a_sketch_has_its_labels_as_text(draw, said, tmp_path):
    draw(tmp_path / "sketch.svg")
    assert said in (tmp_path / "sketch.svg").read_text("utf-8")


def test_the_committed_pictures_are_small():
    assert all((FIGURES / name).stat().st_size < 3e6 for name in PICTURES)
    gallery = re.findall(r"figures/(\w+\.png)", (FIGURES.parent / "gallery.md").read_text("utf-8"))
    assert sum((FIGURES / name).stat().st_size for name in gallery) < 2e6
