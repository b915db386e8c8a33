# SPDX-License-Identifier: Apache-2.0
"""Messages of the estimator: samples in, estimates and the nearest twin out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from drill_twin.api.estimator import Estimator
from drill_twin.core.rig_channels import channel_of
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level, Status, exact
from drill_twin.io.messages.encode import TwinEncoder
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES
from drill_twin.io.scene_geometry import string_geometry
from drill_twin.studies.estimation import Band, Estimate, unit_of

_NAME = "estimate"
_LIKELY = 0.5
"""Share of the members from which a sentence speaks of whirl."""
_TRUST = {Level.OK: "good", Level.WARN: "doubtful", Level.ERROR: "unusable"}
_VALUES = ("torque", "motor_torque", "hookload", "top_drive_speed", "bit_speed", "weight_on_bit", "rotation")
"""Channels and set-points of a message like `/rig/state`."""


def values_of(state: JointState, *, set_points: bool) -> dict[str, float]:
    """Channels of a message like `/rig/state` by name, NaN for what it does not have; set-points if asked for."""
    found = {}
    for name in _VALUES:
        if name not in {"weight_on_bit", "rotation"} or set_points:
            channel = channel_of(name)
            known = channel.joint in state.names and (values := getattr(state, channel.array)).size
            found[name] = float(values[state.names.index(channel.joint)]) if known else math.nan
    return found


def statuses(found: Estimate, troubles: Mapping[str, int]) -> list[Status]:
    """The estimate: its sentence with alarm and chance of whirl, then a status for each number and virtual sensor.

    These have the level of the trust in them: OK, WARN or ERROR; in words `estimates` of the first.
    """
    trust, doubt = trust_in(found)
    level, text = trust, doubt or "the model explains what is measured"
    if found.alarm:
        level = Level.ERROR
    elif trust is Level.OK and found.chance >= _LIKELY:
        level, text = Level.WARN, "whirl is likely soon" if found.whirls <= _LIKELY else "the string whirls"
    values = {"estimates": _TRUST[trust], "whirls": exact(found.whirls), "chance_of_whirl": exact(found.chance)}
    values |= {f"misfit_{name}": exact(value) for name, value in found.misfit.items()}
    values |= {f"samples_{kind.replace(' ', '_')}": str(count) for kind, count in troubles.items()}
    values |= {"absurd_beside_the_model": str(found.absurd), "members_replaced": str(found.replaced)}
    return [
        Status(_NAME, level, text, values),
        *(_status(f"{_NAME}: {key}", band, "", trust) for key, band in found.numbers.items()),
        *(_status(f"{_NAME}: {name}", band, unit_of(name), trust) for name, band in found.sensors.items()),
    ]


def trust_in(found: Estimate) -> tuple[Level, str]:
    """Trust in the numbers of an estimate, and the reason against it: WARN for doubtful ones, ERROR for unusable."""
    if not all(math.isfinite(band.mean) for band in found.numbers.values()):
        return Level.ERROR, "the filter has failed: an estimate is not finite"
    if found.unmeasured > 0.0:
        level = Level.WARN if found.unmeasured <= GONE else Level.ERROR
        return level, f"nothing sound was measured for {found.unmeasured:g} s: the ensemble runs alone"
    return (Level.WARN, found.alarm) if found.alarm else (Level.OK, "")


def _status(name: str, band: Band, unit: str, trust: Level) -> Status:
    values = {"mean": band.mean, "deviation": band.deviation, "low": band.low, "high": band.high}
    text = f"{band.mean:.4g} ({band.low:.4g} to {band.high:.4g}) {unit}".rstrip()
    return Status(name, trust, text, {key: exact(value) for key, value in values.items()})


class NearestTwin:
    """Encodes the frames of the nearest member."""

    def __init__(self, estimator: Estimator) -> None:
        self._encoder = TwinEncoder(string_geometry(estimator.filter.members.twins[0]))

    def messages(self, found: Estimate, origin: float) -> Iterator[tuple[str, bytes]]:
        """Topics and bytes of the frames of a window, stamped by the rig's clock, whose time zero is `origin` [s]."""
        for frame in found.frames:
            stamped = Frames.of(frame._replace(time=origin + frame.time))
            yield RIG_STATE, self._encoder.rig_state(stamped)[0]
            yield MARKS_STATE, self._encoder.marks(stamped)[0]
            yield STRING_POSES, self._encoder.poses(stamped)[0]
