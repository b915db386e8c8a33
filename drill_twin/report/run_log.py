# SPDX-License-Identifier: Apache-2.0
"""Record of a run beside its motion: the `run` block of the scene, the simulator's diagnostics, live findings.

The findings of the analyzer that ran with the twin are compared with the findings of the analysis of the bag.
"""

from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.files.yaml_reader import YamlError, plain_yaml
from drill_twin.core.numerals import number, whole_number
from drill_twin.dynamics.twin.frame import COUNTS
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.stamps import raw_header_stamp, seconds
from drill_twin.io.messages.whirl_encode import OnsetMessage, decode_onset
from drill_twin.runs.monitor import RecordedRejections, recorded_sentences

_SIMULATORS = {"simulator", "twin"}
_SPEEDS = ("realtime_factor", "physics_speed")


class RunLog:
    """Latest values of the `run` block and of the diagnostics."""

    def __init__(self, info: dict[str, Any] | None = None) -> None:
        self.info = info or {}
        """Content of the `run` block: version, seed, elements, step, effects, pace, start."""
        self.speeds: dict[str, float | None] = dict.fromkeys(_SPEEDS)
        """Simulated over wall time, and over the time spent computing the motion; None where the bag does not say."""
        self.steps: dict[str, int] = {}
        """Counts of time steps, by the names in `COUNTS`."""
        self.left_out: list[str] = []
        """Missing effects and notes on the scene, a sentence each."""
        self.guard = RecordedRejections()
        """Rejected frames, and the energy balance."""
        self._energies: dict[int, dict[str, float]] = {}

    def on_scene(self, raw: bytes) -> None:
        """Read a `/twin/scene`.

        Raises:
            MessageError: The message cannot be decoded.
        """
        self.info = _run_block(read_string(raw)) or self.info

    def on_diagnostics(self, raw: bytes) -> None:
        """Read a `/diagnostics`; statuses of other nodes than the simulator are ignored.

        Raises:
            MessageError: The message cannot be decoded.
        """
        stamp, statuses = decode_diagnostics(raw)
        for status in statuses:
            values = status.values
            if status.name.rpartition("/")[2] in _SIMULATORS and "realtime_factor" in values:
                self.speeds |= {key: x for key in _SPEEDS if (x := number(values.get(key, ""))) is not None}
                self.steps |= {key: n for key in COUNTS if (n := whole_number(values.get(key, ""))) is not None}
                self.left_out = recorded_sentences(values)
                self.guard.update(values)
                if self.guard.energy:
                    self._energies[stamp] = {"time": seconds(stamp), **self.guard.energy}

    @property
    def energy(self) -> dict[str, Array]:
        """Energy balance and `time` [s] of each report, shape (K,); empty without an audit."""
        reports = list(self._energies.values())
        return {key: np.array([report[key] for report in reports]) for key in (reports[0] if reports else ())}


def scene_content(text: str) -> dict[str, Any]:
    """Keys of a scene text; empty if the text is not YAML, or no mapping."""
    try:
        content = plain_yaml(text)
    except YamlError:
        return {}  # the whirl pipeline reports what is wrong with the scene
    return content if isinstance(content, dict) else {}


def _run_block(text: str) -> dict[str, Any]:
    """Content of the `run` block of a scene text; empty if there is none."""
    run = scene_content(text).get("run")
    if not isinstance(run, dict):
        return {}
    effects = run.get("effects")
    texts = isinstance(effects, list) and all(isinstance(name, str) for name in effects)
    numbers = {key: run[key] for key in ("seed", "elements", "step_s") if isinstance(run.get(key), int | float)}
    words = {key: run[key] for key in ("version", "pace", "started") if isinstance(run.get(key), str)}
    return numbers | words | ({"effects": effects} if texts else {})


class LiveFindings:
    """Recorded `/whirl/state` and `/whirl/onset`, beside the `/whirl/state` that the analysis gives."""

    def __init__(self) -> None:
        self.onset: OnsetMessage | None = None
        """Last onset announced."""
        self._recorded: dict[int, bytes] = {}
        self._analysed: dict[int, bytes] = {}

    def on_state(self, raw: bytes) -> None:
        """Keep a recorded `/whirl/state`."""
        self._recorded[raw_header_stamp(raw)] = raw

    def on_onset(self, raw: bytes) -> None:
        """Keep a recorded `/whirl/onset`.

        Raises:
            MessageError: The message cannot be decoded.
        """
        self.onset = decode_onset(raw)[1]

    def on_analysed(self, raw: bytes) -> None:
        """Keep a `/whirl/state` of the analysis of the bag."""
        self._analysed[raw_header_stamp(raw)] = raw

    @property
    def messages(self) -> int:
        """Number of recorded `/whirl/state`."""
        return len(self._recorded)

    @property
    def differing(self) -> int:
        """Number of recorded `/whirl/state` that differ from the analysis in any byte."""
        return sum(self._analysed.get(stamp) != raw for stamp, raw in self._recorded.items())
