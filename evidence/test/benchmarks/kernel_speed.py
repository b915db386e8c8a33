# SPDX-License-Identifier: Apache-2.0
"""The kernel's history: `make bench` runs these with pytest-benchmark and keeps what it finds in .benchmarks/.

A frame holds a hundred steps of the peers' scene after contact has begun; compare with `pytest-benchmark compare`.
"""

import pytest

from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL, SPATIAL
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.benchmarks.kernel.examples import full_scene, scene_with

CONTACT = 0.6  # simulated time after which the rod lies against the wall [s]


def follow(benchmark, scene: Scene) -> None:
    """Time frames that follow one another."""
    schedule = Schedule.from_scene(scene)
    period = 1.0 / scene.numerics.frame_rate
    twin = Twin(scene)
    twin.advance(schedule.at(CONTACT), CONTACT)
    before = twin.time

    def frame() -> None:
        twin.advance(schedule.at(twin.time + period), period)

    benchmark.extra_info["elements"] = twin.elements
    benchmark.extra_info["steps a frame"] = round(period / twin.step_size)
    benchmark.pedantic(frame, rounds=20, warmup_rounds=2)
    assert twin.time > before


@pytest.mark.parametrize("form", [SPATIAL, LATERAL])
@pytest.mark.parametrize("elements", [50, 200])
def test_peers_scene(benchmark, form, elements):
    follow(benchmark, full_scene(elements, form))


@pytest.mark.parametrize("form", [SPATIAL, LATERAL])
def test_bare_rod(benchmark, form):
    follow(benchmark, scene_with("bare rod", form, 200))
