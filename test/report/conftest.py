# SPDX-License-Identifier: Apache-2.0
"""A bag with a known motion: steady rotation about a bent shape, then a whirl of given radius and frequency."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import call, inside

from drill_twin.core.rig_channels import RIG_JOINTS
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.cdr import JointStateTemplate, PoseArrayTemplate
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.drawing.transforms import orientation
from drill_twin.io.messages.encode import MARK_AXES, encode_string
from drill_twin.io.messages.topics import DIAGNOSTICS, MARKS_STATE, RIG_STATE, STRING_POSES, TWIN_SCENE
from drill_twin.report import ReportFiles, build_report
from drill_twin.scene import Scene, load_scene

__all__ = ["call", "inside"]

ROTATION, WHIRL = 2.0, -0.6  # rev/s, Hz
BOW, ORBIT = 0.001, 0.030  # m
BEGIN, END, RATE = 3.0, 12.0, 100.0  # s, s, Hz
WEIGHT = 35.0  # N
STEPS = {"steps": "6000", "cut_steps": "21", "steps_above_tolerance": "7"}
RUN = "run: {version: 9.9.9, seed: 7, elements: 10, step_s: 0.002, effects: [gravity, wall], pace: realtime}\n"

Message = tuple[str, int, bytes]


@pytest.fixture(scope="session")
def known_scene() -> Scene:
    return load_scene("pa6_bench")


def centre(time: float) -> complex:
    """Centre line at every mark [m]."""
    grown = min(max((time - BEGIN) / 0.5, 0.0), 1.0)
    return BOW * np.exp(2j * math.pi * ROTATION * time) + grown * ORBIT * np.exp(2j * math.pi * WHIRL * time)


def known_messages(scene: Scene) -> Iterator[Message]:
    places = scene.mark_table
    marks = JointStateTemplate([f"{place.name}/{axis}" for place in places for axis in MARK_AXES])
    rig, poses = JointStateTemplate(RIG_JOINTS), PoseArrayTemplate(11)
    height = np.linspace(-scene.length, 0.0, 11)
    yield TWIN_SCENE, 0, encode_string(scene.to_yaml() + RUN)
    for k in range(1, int(END * RATE) + 1):
        time, stamp = k / RATE, k * round(1e9 / RATE)
        spin = 2.0 * math.pi * ROTATION * time
        z = centre(time)
        state = np.zeros((len(places), len(MARK_AXES)))
        for row, place in zip(state, places, strict=True):
            point = z + place.wall_offset * np.exp(1j * spin)
            row[:] = point.real, point.imag, place.distance_from_bit - scene.length, spin
        zero = np.zeros(state.size)
        yield MARKS_STATE, stamp, marks.fill(stamp, state.ravel(), zero, zero)
        speed, force = (2.0 * math.pi * ROTATION, 2.0 * math.pi * ROTATION, 0.0, 0.0), (0.1, 0.0, -12.0, WEIGHT)
        yield RIG_STATE, stamp, rig.fill(stamp, (spin, spin, 0.0, 0.0), speed, force)
        shape = np.sin(np.pi * height / scene.length)
        nodes = np.stack((z.real * shape, z.imag * shape, height), axis=1)
        tangents = np.gradient(nodes, height, axis=0)
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        turned = orientation(tangents, np.full(11, spin))
        yield STRING_POSES, stamp, poses.fill(stamp, nodes, turned)
    cost = Status("simulator", Level.OK, "fine", {"realtime_factor": "0.998", "physics_speed": "12.500", **STEPS})
    yield DIAGNOSTICS, stamp, encode_diagnostics(stamp, [cost])


@pytest.fixture(scope="session")
def messages(known_scene) -> list[Message]:
    return list(known_messages(known_scene))


@pytest.fixture
def write(tmp_path) -> Callable[..., Path]:
    """Write messages to a new bag and return its folder."""

    def make(rows: list[Message], name: str = "run_0", **options: object) -> Path:
        with BagWriter(tmp_path / name, **options) as bag:
            for row in rows:
                bag.write(*row)
        return bag.folder

    return make


@pytest.fixture(scope="session")
def known_bag(messages, tmp_path_factory) -> Path:
    with BagWriter(tmp_path_factory.mktemp("known") / "run_0") as bag:
        for row in messages:
            bag.write(*row)
    return bag.folder


@pytest.fixture(scope="session")
def known_report(known_bag, tmp_path_factory) -> ReportFiles:
    """Its report; for reading only."""
    return build_report(known_bag, tmp_path_factory.mktemp("report") / "made" / "for_it")
