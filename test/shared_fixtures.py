# SPDX-License-Identifier: Apache-2.0
"""What several rooms of the test house share: runs of the bench, a drawn string, small disks, pages in a browser."""

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from drill_twin.core.process import use_one_thread_of_blas

use_one_thread_of_blas()  # as commands and nodes do, before numpy: workers share the cores, and its threads wait

import numpy as np  # noqa: E402
from browser import Browser  # noqa: E402
from made_up import MARKS, make_frame  # noqa: E402

from drill_twin.io.messages.drawing.geometry import StringGeometry  # noqa: E402
from drill_twin.runs import Outcome, Session  # noqa: E402
from drill_twin.scene import Scene, load_scene  # noqa: E402

__all__ = ["make_frame"]


@pytest.fixture(scope="session")
def make_geometry() -> Callable[..., StringGeometry]:
    def make(nodes: int = 51) -> StringGeometry:
        return StringGeometry(
            node_distances=np.linspace(0.0, 8.0, nodes),
            mark_names=MARKS,
            mark_distances=(4.4, 2.5, 0.5, 0.5),
            length=8.0,
            outer_radius=0.00825,
            hole_radius=0.09,
            hole_steps=((0.0, 8.0, 0.09),),
            string_steps=((0.0, 8.0, 0.00825),),
        )

    return make


@pytest.fixture(scope="session")
def bench_scene() -> Scene:
    """The paper's bench, coarse, short, and pushed so hard that it whirls within a second."""
    changes = {
        "wob": "100 N", "duration": "3", "rig.weight_on_bit.duration": "1 s", "rig.rotation.duration": "0.5 s",
        "effects.bow.amplitude": "2 mm", "numerics.elements": "8",
    }  # fmt: skip
    return load_scene("pa6_bench", overrides=changes)


@pytest.fixture(scope="session")
def bench_run(bench_scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """A real run of it without ROS; its bag is for reading only."""
    return Session(bench_scene).run(tmp_path_factory.mktemp("bench") / "bag_0")


@pytest.fixture
def browse(tmp_path):
    """Open a page in a browser."""
    browsers = []

    def begin(url, *given, **more):
        browsers.append(Browser(tmp_path, url, *given, **more))
        return browsers[-1]

    yield begin
    for browser in browsers:
        browser.close()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Callable[[int], Path]]:
    """Mount a filesystem of a size [bytes], so that a full disk is one; needs the right to mount."""
    mounted: list[Path] = []

    def make(size: int) -> Path:
        folder = tmp_path / f"disk_{len(mounted)}"
        folder.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", f"size={size},mode=777", "none", str(folder)]
        said = subprocess.run(command, capture_output=True, text=True, check=False)
        if said.returncode:
            pytest.skip(f"cannot mount a small filesystem here: {said.stderr.strip()}")
        mounted.append(folder)
        return folder

    yield make
    for folder in mounted:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)
