# SPDX-License-Identifier: Apache-2.0
"""Codes of the motions, for messages that carry numbers: `/whirl/state`, `/twin/summary`. They are kept."""

from __future__ import annotations

from enum import IntEnum
from typing import Self

from drill_twin.whirl.criteria import BitMotion, MotionState


class MotionCode(IntEnum):
    """Code of each `MotionState`: from 3 on the string whirls."""

    NOT_OBSERVABLE = 0
    AT_REST = 1
    FIXED_AXIS = 2
    SYNCHRONOUS_WHIRL = 3
    FORWARD_WHIRL = 4
    REVERSE_WHIRL = 5
    ROLLING = 6
    SECOND_BENDING = 7
    SPIRAL = 8
    IRREGULAR = 9

    @classmethod
    def of(cls, state: MotionState) -> Self:
        """Code of a motion state."""
        return cls[state.name]

    @property
    def state(self) -> MotionState:
        """Motion state of the code; its value is the name in words."""
        return MotionState[self.name]

    @property
    def whirls(self) -> bool:
        """True for a whirl."""
        return self >= MotionCode.SYNCHRONOUS_WHIRL


class StickSlipCode(IntEnum):
    """Code of each `BitMotion`, by its severity."""

    UNKNOWN = 0
    AT_REST = 1
    STARTING = 2
    STEADY = 3
    VIBRATION = 4
    STICK_SLIP = 5
    STANDS = 6

    @classmethod
    def of(cls, motion: BitMotion) -> Self:
        """Code of a motion of the bit."""
        return cls[motion.name]
