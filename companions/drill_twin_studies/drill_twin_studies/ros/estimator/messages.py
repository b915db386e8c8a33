# SPDX-License-Identifier: Apache-2.0
"""Messages of the estimator: samples in, estimates and the nearest twin out."""

import math
from collections.abc import Iterator

from drill_twin.core.rig_channels import channel_of
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level, exact
from drill_twin.io.messages.encode import TwinEncoder
from drill_twin.io.messages.good_samples import GONE
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE, STRING_POSES
from drill_twin_studies.estimation import Estimate

_LIKELY = 0.5
"""Share of the members from which a sentence speaks of whirl."""
_VALUES = ("torque", "motor_torque", "hookload", "top_drive_speed", "bit_speed", "weight_on_bit", "rotation")
"""Channels and set-points of a message like `/rig/state`."""


def values_of(state: JointState, *, set_points: bool) -> dict[str, float]:
    """Channels of a message like `/rig/state` by name, NaN for what it does not have; set-points if asked for."""
    wanted = [name for name in _VALUES if set_points or name not in {"weight_on_bit", "rotation"}]
    return {name: float(state.column(channel_of(name).array, channel_of(name).joint)) for name in wanted}


def encode_estimate(stamp: int, found: Estimate) -> bytes:
    """CDR of an estimate, a message of `/estimate/state`, at a stamp [ns]."""
    level, _ = trust_in(found)
    values = {"trust": float(level), "alarm": float(bool(found.alarm)), "whirls": found.whirls}
    values |= {"unexplained": sum(one.end - one.start for one in found.spans), "chance_of_whirl": found.chance}
    for name, band in {**found.numbers, **found.sensors}.items():
        values |= {name: band.mean, f"{name}/deviation": band.deviation}
        values |= {f"{name}/low": band.low, f"{name}/high": band.high}
    return JointStateTemplate(tuple(values), velocity=False, effort=False).fill(stamp, list(values.values()))


def verdict_of(found: Estimate) -> tuple[Level, str]:
    """Level and sentence for the diagnostics: what an estimate that is not doubted says of whirl."""
    if found.chance >= _LIKELY:
        return Level.WARN, "whirl is likely soon" if found.whirls <= _LIKELY else "the string whirls"
    return Level.OK, "the model explains what is measured"


def values_for_diagnostics(found: Estimate) -> dict[str, str]:
    """Misfit of each channel, and the number of samples left out."""
    values = {f"misfit_{name}": exact(value) for name, value in found.misfit.items()}
    for name, one in found.goodness.items():
        values |= {f"residual_over_noise_{name}": exact(one.ratio), f"chi_square_{name}": exact(one.chi_square)}
        values |= {f"autocorrelation_{name}": exact(one.correlation), f"in_band_{name}": exact(one.inside)}
    values |= {"not_told": ", ".join(found.untold)} if found.untold else {}
    values |= {"remembered": found.remembered} if found.spans else {}
    values |= {f"withheld_{name}": reason for name, reason in found.withheld.items()}
    return values | {"absurd_beside_the_model": str(found.absurd)}


def trust_in(found: Estimate) -> tuple[Level, str]:
    """Trust in the numbers of an estimate, and the reason against it: WARN for doubtful ones, ERROR for unusable."""
    if not all(math.isfinite(band.mean) for band in found.numbers.values()):
        return Level.ERROR, "the filter has failed: an estimate is not finite"
    if found.unmeasured > 0.0:
        level = Level.WARN if found.unmeasured <= GONE else Level.ERROR
        return level, f"nothing sound was measured for {found.unmeasured:g} s: the ensemble runs alone"
    return (Level.WARN, found.alarm) if found.alarm else (Level.OK, "")


def nearest_twin(encoder: TwinEncoder, frames: Frames, origin: float) -> Iterator[tuple[str, bytes]]:
    """Topics and bytes of the frames of the nearest member, stamped by the rig's clock.

    Args:
        encoder: Encoder for its string.
        frames: Frames of a window.
        origin: Time of the rig's clock at which the estimate begins [s].
    """
    stamped = frames._replace(time=origin + frames.time)
    for raws in zip(encoder.rig_state(stamped), encoder.marks(stamped), encoder.poses(stamped), strict=True):
        yield from zip((RIG_STATE, MARKS_STATE, STRING_POSES), raws, strict=True)
