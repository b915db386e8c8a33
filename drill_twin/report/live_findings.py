# SPDX-License-Identifier: Apache-2.0
"""Findings recorded by the analyzer that ran with the twin, compared with those of the analysis of the bag."""

from __future__ import annotations

from drill_twin.io.messages.stamps import unpack_stamp
from drill_twin.io.messages.whirl_encode import OnsetMessage, decode_onset


class LiveFindings:
    """Recorded `/whirl/state` and `/whirl/onset`, beside the `/whirl/state` that the analysis gives."""

    def __init__(self) -> None:
        self.onset: OnsetMessage | None = None
        """Last onset announced."""
        self._recorded: dict[int, bytes] = {}
        self._analysed: dict[int, bytes] = {}

    def on_state(self, raw: bytes) -> None:
        """Keep a recorded `/whirl/state`."""
        self._recorded[unpack_stamp(raw)] = raw

    def on_onset(self, raw: bytes) -> None:
        """Keep a recorded `/whirl/onset`.

        Raises:
            MessageError: It cannot be decoded.
        """
        self.onset = decode_onset(raw)[1]

    def on_analysed(self, raw: bytes) -> None:
        """Keep a `/whirl/state` of the analysis of the bag."""
        self._analysed[unpack_stamp(raw)] = raw

    @property
    def messages(self) -> int:
        """Number of recorded `/whirl/state`."""
        return len(self._recorded)

    @property
    def differing(self) -> int:
        """Number of those that differ from the analysis in any byte."""
        return sum(self._analysed.get(stamp) != raw for stamp, raw in self._recorded.items())
