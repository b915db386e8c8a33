# SPDX-License-Identifier: Apache-2.0
"""Coarse operating map of the scene on the topics, made by `drill-twin map` in a child process."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

from drill_twin.core.errors import DrillTwinError, RunError
from drill_twin.core.process import child_environment
from drill_twin.scene import Scene
from drill_twin.studies.maps import OperatingMap, read_map

_LOW, _HIGH = 0.025, 1.1
"""Ranges that the map has by default, over the set-points of the scene."""
_STEPS = 8
_NICE = 10


class MapMaker:
    """A child process that makes the map, at low priority, so that the nodes keep real time."""

    def __init__(self, scene: Scene, settings: SimpleNamespace) -> None:
        """Start it.

        Args:
            scene: The scene.
            settings: Parameters `wob`, `rpm`, `runs` and `workers` of the node.

        Raises:
            DrillTwinError: No range is given, and the scene has no set-point to take one from.
        """
        rig = scene.rig
        wob = settings.wob or _range("wob", rig.weight_on_bit.value, "N")
        rpm = settings.rpm or _range("rpm", rig.rotation.value, "rad/s")
        self._runs = settings.runs
        self._folder = tempfile.TemporaryDirectory(prefix="drill_twin_map_")
        self._out = Path(self._folder.name)
        (self._out / "scene.yaml").write_text(scene.to_yaml(), "utf-8")
        words = ["map", str(self._out / "scene.yaml"), "--wob", wob, "--rpm", rpm, "--runs", str(settings.runs)]
        words += ["--steps", str(_STEPS), "--workers", str(settings.workers), "--out", str(self._out)]
        with (self._out / "log").open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "drill_twin.cli", *words], env=child_environment(), stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=log, start_new_session=True,
            )  # fmt: skip
        os.setpriority(os.PRIO_PROCESS, self._process.pid, _NICE)

    @property
    def progress(self) -> str:
        """Runs made so far, as text."""
        journal = self._out / "runs.jsonl"
        made = max(journal.read_bytes().count(b"\n") - 1, 0) if journal.exists() else 0
        return f"no advice yet: making a coarse map, {made} of at most {self._runs} runs ({made / self._runs:.0%}) made"

    def result(self) -> OperatingMap | None:
        """The map, once it is made.

        Raises:
            RunError: It could not be made.
        """
        code = self._process.poll()
        if code is None:
            return None
        if code:
            lines = (self._out / "log").read_text("utf-8", "replace").split("\n")
            said = next((line for line in reversed(lines) if line.strip()), f"exit code {code}")
            raise RunError(f"no map of this scene: {said.removeprefix('drill-twin: ')}")
        return read_map(self._out / "map.json")

    def close(self) -> None:
        """End the child, and remove its files."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()


def _range(name: str, value: float, unit: str) -> str:
    if not value > 0.0 or not math.isfinite(value):
        raise DrillTwinError(
            f"parameter {name}: expected a range for the map, for the scene has the set-point {value:g} {unit}"
        )
    return f"{_LOW * value!r}..{_HIGH * value!r} {unit}"
