# SPDX-License-Identifier: Apache-2.0
"""A bench that is quick to run: the paper's, coarse and short, in its lateral form."""

from pathlib import Path

import pytest

from drill_twin.scene import Scene, load_scene

QUICK = {
    "effects.stretch": "off", "effects.torsion": "off", "numerics.elements": "8", "duration": "1.2",
    "rig.weight_on_bit.duration": "0.3 s", "rig.rotation.duration": "0.2 s", "effects.bow.amplitude": "2 mm",
}  # fmt: skip


@pytest.fixture(scope="session")
def quick_bench() -> Scene:
    return load_scene("pa6_calibrated", overrides=QUICK)


@pytest.fixture
def quick_file(quick_bench: Scene, tmp_path: Path) -> Path:
    """The same as a file, for the command line."""
    file = tmp_path / "quick.yaml"
    file.write_text(quick_bench.to_yaml(), "utf-8")
    return file
